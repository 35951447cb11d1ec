// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scenario/choices.h"

namespace reamsim {

// Glenoid and implant of a scenario; see scenario.h.

struct LandmarkSettings {
  Vec3 glenoid_center_mm = Vec3::Zero();
  Vec3 trigonum_spinae_mm = Vec3::Zero();
  Vec3 inferior_angle_mm = Vec3::Zero();

  static auto fields(auto& self) {
    return std::tie(self.glenoid_center_mm, self.trigonum_spinae_mm, self.inferior_angle_mm);
  }
};

/// What definitions of version need beyond the landmarks (sim/anatomy/version.cpp); B.
struct VersionLandmarks {
  std::vector<Vec3> face_mm;  ///< on the rim of the face; empty: not given
  // In one axial slice:
  std::optional<Vec3> anterior_margin_mm;
  std::optional<Vec3> posterior_margin_mm;
  std::optional<Vec3> medial_tip_mm;
  std::optional<Vec3> vault_tip_mm;

  /// Those that are given in the slice, by their keys.
  [[nodiscard]] std::vector<std::pair<const char*, Vec3>> in_slice() const {
    std::vector<std::pair<const char*, Vec3>> out;
    for (const auto& [key, point] :
         {std::pair("anterior_margin_mm", anterior_margin_mm), std::pair("posterior_margin_mm", posterior_margin_mm),
          std::pair("medial_tip_mm", medial_tip_mm), std::pair("vault_tip_mm", vault_tip_mm)}) {
      if (point) out.emplace_back(key, *point);
    }
    return out;
  }
};

/// The glenoid frame: centre, normal and superior direction; or a point near the centre of a face to be found, with or
/// without a superior direction; or landmarks.
struct GlenoidSettings {
  std::optional<Vec3> near_mm;
  std::optional<Vec3> center_mm;
  std::optional<Vec3> normal;
  std::optional<Vec3> superior;
  std::optional<LandmarkSettings> landmarks;
  std::vector<Vec3> rim_mm;  ///< edge of the joint face before reaming, in order round it; empty: not given
  VersionLandmarks version_landmarks;

  /// Whether there is a frame, or a point from which to find it.
  [[nodiscard]] bool is_given() const { return near_mm || center_mm || landmarks; }
};

/// A wedge or step on the back of an implant, from the line across `direction`, `start_mm` from its axis, on. wedge:
/// the back is the lower of the plain back and its copy rotated by `angle_deg` about that line; step: `step_mm` below
/// it.
struct AugmentSettings {
  AugmentShape shape = AugmentShape::wedge;
  double angle_deg = 15;
  double step_mm = 5;
  Vec3 direction{1, 0, 0};  ///< where the implant becomes thicker, in the frame of the implant; z is ignored
  double start_mm = 0;      ///< 0: half wedge
};

/// A closed mesh in the frame of the implant. What lies deeper than `pegs_below_mm` below the plain back is peg, the
/// rest of its underside is the back.
struct ImplantMeshSettings {
  std::string path;
  double scale = 1;  ///< mm per file unit
  double pegs_below_mm = 1;
};

/// A peg, or with a second one beside it a keel: all points within diameter/2 of a segment, in the implant's frame.
struct PegSettings {
  Vec3 from_mm = Vec3::Zero();
  Vec3 to_mm{0, 0, -10};
  double diameter_mm = 5;
};

/// A glenoid component. Its frame: origin at the apex of its back, +z out of the bone along its axis, +y superior.
struct ImplantSettings {
  double backside_radius_mm = 0;  ///< 0: flat
  double diameter_mm = 0;         ///< of a round footprint; with 0 and no width_mm: the footprint is the reamed face
  double gap_mm = 0.5;            ///< the implant counts as seated up to this gap
  double width_mm = 0;            ///< of the footprint, along x; 0: see diameter_mm
  double height_mm = 0;           ///< of the footprint, along y
  FootprintShape footprint = FootprintShape::ellipse;
  ImplantFrame frame = ImplantFrame::reamer;  ///< of center_mm, axis, superior
  Vec3 center_mm = Vec3::Zero();   ///< of the apex of the back; seated, only its place across the axis counts
  Vec3 axis{0, 0, 1};              ///< out of the bone
  std::optional<Vec3> superior{};  ///< without it that of the glenoid, or else +y of `frame`
  bool seat = true;                ///< translated along the axis until it rests on the bone
  double thickness_mm = 0;         ///< from back to articular surface, along the axis
  double support_depth_mm = 2;     ///< thickness of the layer of bone that supports the implant
  double vault_depth_mm = 28;      ///< depth of the vault below the unreamed face
  std::optional<ImplantMeshSettings> mesh{};  ///< has footprint, augment and pegs
  std::optional<AugmentSettings> augment{};
  std::vector<PegSettings> pegs{};
};

struct MetricSettings {
  double dense_g_cm3 = 1;  ///< least density of subchondral and cortical bone; below: trabecular
  std::optional<ImplantSettings> implant;
};

}  // namespace reamsim
