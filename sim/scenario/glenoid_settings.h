// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

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
    const auto add = [&](const char* key, const std::optional<Vec3>& point) {
      if (point) out.emplace_back(key, *point);
    };
    add("anterior_margin_mm", anterior_margin_mm);
    add("posterior_margin_mm", posterior_margin_mm);
    add("medial_tip_mm", medial_tip_mm);
    add("vault_tip_mm", vault_tip_mm);
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
};

}  // namespace reamsim
