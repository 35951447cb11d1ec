// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/winding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sim/base/parallel.h"

namespace reamsim {

namespace {

/// A triangle seen along the axis: first and second coordinate across it, third along it.
using Seen = std::array<Vec3, 3>;

/// The winding number of a triangle about a point in the plane across the axis: 1, −1 or 0. Each edge is computed from
/// its lower to its upper end, which gives the same in both of its triangles.
int winding_in_plane(const Seen& t, double u, double v) {
  int sum = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const Vec3 &a = t[c], &b = t[(c + 1) % 3];
    if ((a.y() > v) == (b.y() > v)) continue;
    const bool up = b.y() > a.y();
    const Vec3 &low = up ? a : b, &high = up ? b : a;
    if (u < low.x() + (v - low.y()) / (high.y() - low.y()) * (high.x() - low.x())) sum += up ? 1 : -1;
  }
  return sum;
}

/// Where the line meets the plane of the triangle, within the triangle.
double height(const Seen& t, double u, double v) {
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const auto [least, most] = std::minmax({t[0].z(), t[1].z(), t[2].z()});
  if (normal.z() == 0) return 0.5 * (least + most);
  const double z = t[0].z() - (normal.x() * (u - t[0].x()) + normal.y() * (v - t[0].y())) / normal.z();
  return std::clamp(z, least, most);
}

Seen seen_along(const std::array<Vec3, 3>& corners, int axis) {
  Seen out;
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = Vec3(corners[c][(axis + 1) % 3], corners[c][(axis + 2) % 3], corners[c][axis]);
  }
  return out;
}

constexpr std::size_t kMostRows = 2048;  // of LineCrossings

struct Points {
  explicit Points(const Aabb& box) {
    constexpr double kCount = 1e5;
    const Vec3 size = (box.max - box.min).cwiseMax(0.01 * (box.max - box.min).maxCoeff());
    spacing_mm = std::cbrt(size.prod() / kCount);
    for (int axis = 0; axis < 3; ++axis) {
      counts[axis] = std::clamp(static_cast<int>(std::ceil(size[axis] / spacing_mm)), 1, 4096);
    }
    // Not at the middle of the box, where symmetric meshes have their edges.
    first_mm = box.min + 0.4871 * Vec3::Constant(spacing_mm);
  }
  [[nodiscard]] double at(int axis, int i) const { return first_mm[axis] + i * spacing_mm; }

  double spacing_mm = 1;
  Vec3i counts = Vec3i::Ones();
  Vec3 first_mm = Vec3::Zero();
};

/// Adds the winding numbers along both directions of the axis.
void add_windings(const TriangleMesh& mesh, int axis, const Points& points, std::vector<int>& sums) {
  const LineCrossings lines(mesh, axis);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  parallel_items(static_cast<std::size_t>(points.counts[v]), [&](std::size_t row) {
    std::vector<LineCrossings::Crossing> crossings;
    Vec3i point;
    point[v] = static_cast<int>(row);
    for (point[u] = 0; point[u] < points.counts[u]; ++point[u]) {
      lines.along(points.at(u, point[u]), points.at(v, point[v]), crossings);
      int both = 0;
      for (const auto& crossing : crossings) both += crossing.leaving;
      auto next = crossings.begin();
      for (point[axis] = 0; point[axis] < points.counts[axis]; ++point[axis]) {
        for (; next != crossings.end() && next->at_mm < points.at(axis, point[axis]); ++next) {
          both -= 2 * next->leaving;
        }
        sums[index_in(points.counts, point)] += both;
      }
    }
  });
}

std::vector<int> winding_sums(const TriangleMesh& mesh, const Points& points) {
  std::vector<int> out(static_cast<std::size_t>(points.counts.cast<std::int64_t>().prod()), 0);
  for (int axis = 0; axis < 3; ++axis) add_windings(mesh, axis, points, out);
  return out;
}

}  // namespace

TriangleRows::TriangleRows(const TriangleMesh& mesh, int axis, std::size_t count) : rows_(count) {
  const Aabb box = mesh.bounds();
  least_mm_ = box.min[axis];
  row_mm_ = std::max((box.max[axis] - box.min[axis]) / static_cast<double>(count), std::numeric_limits<double>::min());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(mesh.triangles[i]);
    const auto [least, most] = std::minmax({a[axis], b[axis], c[axis]});
    for (std::size_t row = row_of(least); row <= row_of(most); ++row)
      rows_[row].push_back(static_cast<std::uint32_t>(i));
  }
}

std::size_t TriangleRows::row_of(double mm) const {
  const double row = std::floor((mm - least_mm_) / row_mm_);
  return static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(rows_.size() - 1)));
}

LineCrossings::LineCrossings(const TriangleMesh& mesh, int axis)
    : mesh_(mesh),
      axis_(axis),
      rows_(mesh, (axis + 2) % 3, std::clamp<std::size_t>(mesh.triangles.size() / 8, 1, kMostRows)) {}

void LineCrossings::along(double first_mm, double second_mm, std::vector<Crossing>& out) const {
  out.clear();
  for (const std::uint32_t i : rows_.at(second_mm)) {
    const Seen t = seen_along(mesh_.corners(mesh_.triangles[i]), axis_);
    const int leaving = winding_in_plane(t, first_mm, second_mm);
    if (leaving != 0) out.push_back({height(t, first_mm, second_mm), leaving});
  }
  std::ranges::sort(out, {}, &Crossing::at_mm);
}

void LineCrossings::above(const Vec3& point_mm, const std::function<void(std::uint32_t, int)>& visit) const {
  const double u = point_mm[(axis_ + 1) % 3], v = point_mm[(axis_ + 2) % 3];
  for (const std::uint32_t i : rows_.at(v)) {
    const Seen t = seen_along(mesh_.corners(mesh_.triangles[i]), axis_);
    const int leaving = winding_in_plane(t, u, v);
    if (leaving != 0 && height(t, u, v) > point_mm[axis_]) visit(i, leaving);
  }
}

int LineCrossings::winding(const Vec3& point_mm) const {
  int sum = 0;
  above(point_mm, [&sum](std::uint32_t, int leaving) { sum += leaving; });
  return sum;
}

VolumeChange compare_volumes(const TriangleMesh& before, const TriangleMesh& after) {
  constexpr int kHalfOfSix = 3;
  const Points points(before.bounds());
  const std::vector<int> first = winding_sums(before, points), second = winding_sums(after, points);
  const double cell_mm3 = std::pow(points.spacing_mm, 3);
  VolumeChange out;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const bool was = first[i] > kHalfOfSix, is = second[i] > kHalfOfSix;
    out.before_mm3 += was ? cell_mm3 : 0;
    out.after_mm3 += is ? cell_mm3 : 0;
    out.differs_mm3 += was != is ? cell_mm3 : 0;
  }
  return out;
}

}  // namespace reamsim
