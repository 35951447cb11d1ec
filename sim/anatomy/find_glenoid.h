// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/anatomy/fit_face.h"
#include "sim/base/error.h"
#include "sim/bone/bone.h"

namespace reamsim {

/// An articular face found on the surface of a bone.
struct FoundGlenoid {
  GlenoidFrame frame;               ///< origin on the surface, +z out of the face, +y superior
  std::vector<Vec3> rim_mm;         ///< B, in order round the face
  std::string sentence;             ///< for the console: centre, normal, size and residuals
  std::vector<std::string> doubts;  ///< what makes the frame uncertain, a sentence each
};

/// Finds the face round `settings.near_mm`, which lies within about 8 mm of its centre (see fit_face()).
///
/// The centre is the middle of the pear's height on its long axis, moved to the surface along the normal. The normal
/// points to the centre of the sphere; for a face that is no single surface (biconcave) it is that of the plane through
/// the rim, the least-squares form of the intermediate glenoid, from rim to rim (Rouleau et al. 2010). Superior is that
/// of `settings.superior` or the landmarks; else the long axis of the face towards +z of a scan, and else towards its
/// narrow end. Throws InputError (bone.glenoid.near_mm): no bone near the point, no face round it.
FoundGlenoid find_glenoid(const BoneView& bone, const GlenoidSettings& settings, BodySide side);

/// A place on a bone where a glenoid may be. B.
struct FacePlace {
  Vec3 center_mm = Vec3::Zero();  ///< on the surface
  Vec3 normal = Vec3::UnitZ();    ///< out of the bone
  double height_mm = 0, width_mm = 0;
  double confidence = 0;  ///< 0…1: how much the place resembles a glenoid
};

/// What a face is as the place of a glenoid. The confidence is face_score() times the square root of factors that fall
/// to 0 for a height outside 20…52 mm, a width outside 14…42 mm and a vault thinner than 10 mm, and are 1 for a height
/// of 26…46 mm, a width of 19…36 mm and a vault of 15 mm.
FacePlace place_of(const BoneProbe& probe, const FittedFace& face);

/// The place at a frame on the surface, fitted finely; nullopt where there is no face.
std::optional<FacePlace> place_at(const BoneView& bone, const Rigid& bone_from_face);

/// Searches the whole surface of a bone for faces that resemble a glenoid: a rim round a concave or flat face of 20 to
/// 50 mm, with a vault of at least 10 mm behind it, which the acromion and the fossae of the scapula have not. Starts
/// every 5 mm are fitted coarsely (fit_face()); those that are faces are fitted finely. The best come first. Voxels of
/// about 1 mm suffice.
std::vector<FacePlace> search_faces(const BoneView& bone);

}  // namespace reamsim
