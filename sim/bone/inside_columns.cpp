// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/inside_columns.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "sim/base/parallel.h"
#include "sim/mesh/winding.h"

namespace reamsim {

InsideColumns::InsideColumns(const TriangleMesh& mesh, const VoxelGrid& grid) : grid_(grid) {
  const LineCrossings lines(mesh, 2);
  const auto rows = static_cast<std::size_t>(grid.dims.y()), columns = static_cast<std::size_t>(grid.dims.x());
  std::vector<std::vector<Part>> parts_of_row(rows);
  std::vector<char> row_is_simple(rows, 1);
  first_.assign(rows * columns + 1, 0);
  parallel_items(rows, [&](std::size_t y) {
    std::vector<LineCrossings::Crossing> crossings;
    for (std::size_t x = 0; x < columns; ++x) {
      const Vec3 start = grid.center_mm({static_cast<int>(x), static_cast<int>(y), 0});
      lines.along(start.x(), start.y(), crossings);
      const std::size_t before = parts_of_row[y].size();
      int winding = 0;
      for (const auto& crossing : crossings) {
        const int next = winding - crossing.leaving;
        if (winding <= 0 && next > 0) parts_of_row[y].push_back({crossing.at_mm, crossing.at_mm});
        if (winding > 0 && next <= 0) parts_of_row[y].back().end_mm = crossing.at_mm;
        winding = next;
        if (winding < 0 || winding > 1) row_is_simple[y] = 0;
      }
      first_[y * columns + x + 1] = parts_of_row[y].size() - before;
    }
  });
  for (std::size_t column = 1; column < first_.size(); ++column) first_[column] += first_[column - 1];
  for (const auto& parts : parts_of_row) std::ranges::copy(parts, std::back_inserter(parts_));
  for (const Part& part : parts_) volume_mm3_ += (part.end_mm - part.begin_mm) * grid.voxel_mm * grid.voxel_mm;
  simple_ = std::ranges::all_of(row_is_simple, [](char simple) { return simple != 0; });
}

bool InsideColumns::contains(const Vec3i& voxel) const {
  if (!grid_.contains(voxel)) return false;
  const auto column = static_cast<std::size_t>(voxel.x() + std::int64_t{grid_.dims.x()} * voxel.y());
  const double z_mm = grid_.center_mm(voxel).z();
  for (std::size_t i = first_[column]; i < first_[column + 1]; ++i) {
    if (z_mm >= parts_[i].begin_mm && z_mm < parts_[i].end_mm) return true;
  }
  return false;
}

namespace {

using Corners = std::array<Vec3, 3>;

/// Divides at the middles of the edges until they are short enough.
void divide(const Corners& t, double edge_mm, std::vector<Corners>& out) {
  const double longest_mm = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  if (longest_mm <= edge_mm) return out.push_back(t);
  const Vec3 ab = 0.5 * (t[0] + t[1]), bc = 0.5 * (t[1] + t[2]), ca = 0.5 * (t[2] + t[0]);
  for (const Corners& part :
       {Corners{t[0], ab, ca}, Corners{ab, t[1], bc}, Corners{ca, bc, t[2]}, Corners{ab, bc, ca}}) {
    divide(part, edge_mm, out);
  }
}

/// Whether one side of a part of a surface is inside and the other is not, at its middle or near a corner.
bool is_boundary(const LineCrossings& lines, const Corners& t, double beside_mm) {
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  if (normal.norm() == 0) return false;
  const Vec3 step = beside_mm * normal.normalized(), middle = (t[0] + t[1] + t[2]) / 3;
  const auto differs_at = [&](const Vec3& p) { return (lines.winding(p + step) > 0) != (lines.winding(p - step) > 0); };
  return differs_at(middle) || differs_at(0.3 * middle + 0.7 * t[0]) || differs_at(0.3 * middle + 0.7 * t[1]) ||
         differs_at(0.3 * middle + 0.7 * t[2]);
}

}  // namespace

TriangleMesh boundary_of_inside(const TriangleMesh& mesh, double edge_mm) {
  constexpr double kBeside = 1e-7;  // of the size of the mesh
  const LineCrossings lines(mesh, 2);
  const double beside_mm = kBeside * (mesh.bounds().max - mesh.bounds().min).maxCoeff();
  std::vector<std::vector<Corners>> kept(mesh.triangles.size());
  parallel_items(mesh.triangles.size(), [&](std::size_t i) {
    divide(mesh.corners(mesh.triangles[i]), edge_mm, kept[i]);
    std::erase_if(kept[i], [&](const Corners& part) { return !is_boundary(lines, part, beside_mm); });
  });
  TriangleMesh out;
  for (const auto& parts : kept) {
    for (const Corners& part : parts) {
      const auto first = static_cast<std::int32_t>(out.vertices.size());
      out.vertices.insert(out.vertices.end(), part.begin(), part.end());
      out.triangles.push_back({first, first + 1, first + 2});
    }
  }
  return out;
}

}  // namespace reamsim
