// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/tool/profile.h"

namespace reamsim {

/// Signed distances to a tool's surface on a regular grid in (r, z), mm, negative inside: for predictions and lists of
/// bricks, which tolerate errors of a fraction of the pitch.
struct DistanceTable {
  Vec2 first = Vec2::Zero();  ///< (r, z) of the first sample
  double pitch_mm = 1;
  int count_r = 0;
  int count_z = 0;
  std::vector<float> mm;  ///< r fastest

  /// Interpolated at (r, z); infinite beyond the last samples.
  [[nodiscard]] double at(const Vec2& rz) const;
  /// The value of the nearest sample; infinite beyond the samples.
  [[nodiscard]] double nearest(const Vec2& rz) const;
};

/// Over the profile's box and `margin_mm` round it.
DistanceTable distance_table_around(const Profile& profile, double pitch_mm, double margin_mm);

DistanceTable make_distance_table(const Profile& profile, const Vec2& first, double pitch_mm, int count_r, int count_z);

}  // namespace reamsim
