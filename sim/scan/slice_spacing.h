// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim::ct {

/// Slices closer than this fraction of the spacing have the same position.
inline constexpr double kSamePlace = 0.01;

/// Where a slice lies, and how exactly the file says so.
struct SlicePlace {
  double height_mm = 0;     ///< along the normal of the slices
  double half_unit_mm = 0;  ///< half a unit of the last written digit, along the normal
  std::optional<int> instance_number;
};

/// Half a unit of the last written digit of each coordinate of each position "x\y\z". An exporter rounds all of them
/// alike, so trailing zeros that it omits count. Huge where a text has no number.
std::vector<Vec3> half_units(const std::vector<std::string>& positions);

/// Why slices are not evenly spaced.
struct SpacingFault {
  enum class Kind { missing, change, irregular };
  Kind kind = Kind::irregular;
  std::size_t slice = 0;  ///< the gap ends at this slice
  double before_mm = 0;   ///< the usual spacing; before a change
  double gap_mm = 0;      ///< of this gap; after a change
  long missing = 0;       ///< slices; after a change, per gap, if instance numbers jump as well
};

/// Median distance of neighbours, without those at the same place; slices closer than a hundredth of the largest gap
/// are at the same place.
double typical_spacing(const std::vector<SlicePlace>& places);

/// The first fault in slices sorted by height; none where every gap is within 5 % of the typical one, or where even
/// spacing explains all positions within half a unit of their last digit and nothing says that a slice is missing.
/// `header_mm`: the slice spacing in the header, 0: unknown.
std::optional<SpacingFault> spacing_fault(const std::vector<SlicePlace>& places, double header_mm);

/// A line of positions: point_mm + step_mm·k.
struct SliceLine {
  Vec3 point_mm = Vec3::Zero();
  Vec3 step_mm = Vec3::Zero();
};

/// The least-squares line of positions at the places `at` along it; through the first and the last one where that
/// deviates by less than a thousandth of the step.
SliceLine line_through(const std::vector<Vec3>& positions, const std::vector<double>& at);

/// Whether slices with this spacing explain all positions within half a unit of their last digit.
bool explains(const std::vector<SlicePlace>& places, double spacing_mm);

/// A line of `slices` evenly spaced positions with another spacing along it, about the same middle.
SliceLine with_spacing(SliceLine line, double spacing_mm, std::size_t slices);

/// For each slice of an evenly spaced stack, the source slice below it and the weight of the next one.
struct SliceBlend {
  std::size_t below = 0;
  double weight = 0;
};

/// The evenly spaced slices, from the first height to the last, that interpolate sorted heights. Their spacing is the
/// finest that occurs more than once, or a little less.
std::vector<SliceBlend> blends_of(const std::vector<SlicePlace>& places);

}  // namespace reamsim::ct
