// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/anatomy/column_map.h"

namespace reamsim {

/// Lengths of bone along the columns of a map, as integrals of the fraction of bone. Not thread-safe: see
/// BoneFractions.
class ColumnBone {
 public:
  /// `map` must outlive the object. `dense_g_cm3`: the least density of dense bone.
  ColumnBone(const ReamedBone& bone, const ColumnMap& map, double dense_g_cm3);

  [[nodiscard]] double voxel_mm() const { return voxel_mm_; }

  struct Length {
    double bone_mm = 0;   ///< remaining bone
    double dense_mm = 0;  ///< of that, dense bone
  };
  /// The bone in the layer of `depth_mm` below a surface at the height `top_mm` of the map.
  [[nodiscard]] Length layer(const ColumnPlace& place, double top_mm, double depth_mm);

  /// The fraction of remaining bone at a height of the map.
  [[nodiscard]] double fraction(const ColumnPlace& place, double z_mm) {
    return fractions_.at(map_.in_bone(place, z_mm)).after;
  }
  /// The largest fraction of remaining bone between two heights of the map.
  [[nodiscard]] double largest_fraction(const ColumnPlace& place, double top_mm, double bottom_mm);

  /// The length of bone without a gap below a surface at the height `top_mm`, down to `bottom_mm` at most; before or
  /// after reaming. A column beside a wall is filled to the fraction `cover`; elsewhere it is 1.
  [[nodiscard]] double continuous_mm(const ColumnPlace& place, double top_mm, double bottom_mm, double cover,
                                     double Fractions::*state);

 private:
  /// Samples of the fraction from above the surface down, one step each: visit(fractions, length of the step, mm below
  /// `top_mm`) until it returns false.
  template <class Visit>
  void descend(const ColumnPlace& place, double top_mm, double bottom_mm, const Visit& visit);

  const ColumnMap& map_;
  BoneFractions fractions_;
  double voxel_mm_;
};

}  // namespace reamsim
