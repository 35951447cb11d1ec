// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "sim/anatomy/fit_face.h"

namespace reamsim {

/// A place on a bone where a glenoid may be. B.
struct FacePlace {
  Vec3 center_mm = Vec3::Zero();  ///< on the surface
  Vec3 normal = Vec3::UnitZ();    ///< out of the bone
  double height_mm = 0, width_mm = 0;
  double vault_mm = 0;    ///< thickness of the bone behind the centre, along the normal; at most 20
  double confidence = 0;  ///< 0…1: how much the place resembles a glenoid
};

/// What a face is as the place of a glenoid. The confidence is face_score() times the square root of factors that fall
/// to 0 for a height outside 20…52 mm, a width outside 14…42 mm and a vault thinner than 10 mm, and are 1 for a height
/// of 26…46 mm, a width of 19…36 mm and a vault of 15 mm.
FacePlace place_of(const BoneProbe& probe, const FittedFace& face);

/// The place at a frame on the surface, fitted finely; nullopt where there is no face.
std::optional<FacePlace> place_at(const BoneView& bone, const Rigid& bone_from_face);

/// A region of B.
struct Ball {
  Vec3 center_mm = Vec3::Zero();
  double radius_mm = std::numeric_limits<double>::infinity();
};

/// Frames every 5 mm on the surface in a region, +z out of the bone, where the bone is thick and nothing stands in
/// front of it: where fit_face() may start.
std::vector<Rigid> starts_on_surface(const BoneView& bone, const BoneProbe& probe, const Ball& within);

/// Searches the whole surface of a bone for faces that resemble a glenoid: a rim round a concave or flat face of 20 to
/// 50 mm, with a vault of at least 10 mm behind it, which the acromion and the fossae of the scapula have not. Starts
/// every 5 mm are fitted coarsely (fit_face()); those that are faces are fitted finely. The best come first. Voxels of
/// about 1 mm suffice.
std::vector<FacePlace> search_faces(const BoneView& bone);

}  // namespace reamsim
