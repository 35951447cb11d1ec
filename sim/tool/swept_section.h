// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// The radii that a rotating mesh occupies at a height. The section of the mesh at height z is a set of closed curves;
/// each piece sweeps an interval of radii. The circle of any other radius lies entirely inside or outside the mesh, as
/// its winding number tells.
class SweptSection {
 public:
  /// Radii from `low` to `high`, mm.
  struct Interval {
    double low;
    double high;
  };

  /// The mesh (closed, facing outwards; mm, frame T) must outlive the section.
  explicit SweptSection(const TriangleMesh& mesh);

  /// The occupied radii at height `z_mm`: disjoint, ascending.
  [[nodiscard]] std::vector<Interval> at(double z_mm) const;

 private:
  /// A piece of the section, with the inside on its left.
  struct Piece {
    Vec2 from, to;
  };

  [[nodiscard]] std::vector<Piece> cut(double z_mm) const;

  const TriangleMesh& mesh_;
  double bottom_mm_ = 0;
  double slab_mm_ = 1;
  std::vector<std::vector<std::int32_t>> slabs_;  ///< triangles by height
};

/// Whether `radius_mm` lies in one of the intervals.
bool occupied(const std::vector<SweptSection::Interval>& intervals, double radius_mm);

}  // namespace reamsim
