#pragma once

#include <vector>

#include "sim/tool/profile.h"

namespace reamsim {

/// Signed distances to a tool's surface on a raster of (r, z), mm, negative inside: for predictions and for lists of
/// bricks, which need no more than a part of the raster's pitch.
struct DistanceTable {
  Vec2 first = Vec2::Zero();  ///< (r, z) of the first sample
  double pitch_mm = 1;
  int count_r = 0;
  int count_z = 0;
  std::vector<float> mm;  ///< r fastest

  /// Interpolated at (r, z); infinite beyond the last samples.
  [[nodiscard]] double at(const Vec2& rz) const;
  /// Of the nearest sample; infinite beyond the samples. `rz` lies at most half a diagonal of the raster from it.
  [[nodiscard]] double nearest(const Vec2& rz) const;
};

/// Samples of `profile` from `first` on.
DistanceTable make_distance_table(const Profile& profile, const Vec2& first, double pitch_mm, int count_r, int count_z);

}  // namespace reamsim
