// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

// The winding number of a point says how often a surface encloses it. For a surface whose edges cancel (holes_of()) it
// is the number of triangles that a line from the point crosses from inside to outside, less those that it crosses the
// other way, whatever the line. This is exact: no fast approximation (Barill et al. 2018) is needed.

/// The triangles of a mesh by intervals of one coordinate.
class TriangleRows {
 public:
  /// `count`: of the intervals that divide the box of the mesh along the axis, at least one.
  TriangleRows(const TriangleMesh& mesh, int axis, std::size_t count);

  /// Those that can have a point with this coordinate, in the order of the mesh.
  [[nodiscard]] const std::vector<std::uint32_t>& at(double mm) const { return rows_[row_of(mm)]; }

 private:
  [[nodiscard]] std::size_t row_of(double mm) const;

  double least_mm_ = 0;
  double row_mm_ = 1;
  std::vector<std::vector<std::uint32_t>> rows_;
};

/// Where lines parallel to an axis cross a mesh. No line slips through between triangles: both treat an edge alike.
class LineCrossings {
 public:
  struct Crossing {
    double at_mm = 0;
    int leaving = 0;  ///< 1: from inside to outside along the axis; −1: the other way
  };

  /// `axis`: 0, 1 or 2. Keeps a reference to the mesh.
  LineCrossings(const TriangleMesh& mesh, int axis);

  /// The crossings along the axis, in order, at coordinates along the next axes (for axis 1: z and x).
  void along(double first_mm, double second_mm, std::vector<Crossing>& out) const;

  /// Calls visit(triangle, leaving) where the half of a point's line in the direction of the axis crosses the mesh.
  void above(const Vec3& point_mm, const std::function<void(std::uint32_t triangle, int leaving)>& visit) const;
  /// The winding number of a point, by the half of its line in the direction of the axis.
  [[nodiscard]] int winding(const Vec3& point_mm) const;

 private:
  const TriangleMesh& mesh_;
  int axis_;
  TriangleRows rows_;  ///< by the second coordinate
};

/// The volume that a mesh encloses, and where another says otherwise, mm³, on a lattice of some 100,000 points round
/// `before`. With holes: inside is where the mean winding number along the axes' six directions exceeds a half.
struct VolumeChange {
  double before_mm3 = 0;
  double after_mm3 = 0;
  double differs_mm3 = 0;  ///< inside one of them only
};
VolumeChange compare_volumes(const TriangleMesh& before, const TriangleMesh& after);

}  // namespace reamsim
