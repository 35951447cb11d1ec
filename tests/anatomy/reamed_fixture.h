// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <functional>
#include <numbers>

#include "sim/anatomy/run_metrics.h"

namespace reamsim::test {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180;
inline constexpr double kVoxel = 0.5;

/// Distance of a point of B from a solid, mm: negative inside; its slope is at most 1.
using Solid = std::function<double(const Vec3&)>;

inline Solid ball(const Vec3& center, double radius) {
  return [=](const Vec3& p) { return (p - center).norm() - radius; };
}
/// Everything on the side of a plane that its normal points to.
inline Solid above_plane(const Vec3& point, const Vec3& normal) {
  return [=](const Vec3& p) { return -(p - point).dot(normal.normalized()); };
}
/// A rod without ends.
inline Solid rod(const Vec3& point, const Vec3& axis, double radius) {
  return [=](const Vec3& p) { return (p - point).cross(axis.normalized()).norm() - radius; };
}
inline Solid both(const Solid& a, const Solid& b) {
  return [=](const Vec3& p) { return std::max(a(p), b(p)); };
}
inline Solid without(const Solid& a, const Solid& b) {
  return [=](const Vec3& p) { return std::max(a(p), -b(p)); };
}

/// How many of points³ points in a cube, evenly apart, lie outside a solid. `points`: a product of twos and threes.
inline int points_outside(const Solid& solid, const Vec3& center, double edge, int points) {
  constexpr double kHalfDiagonal = 0.8661;
  const double distance = solid(center);
  if (points == 1 || std::abs(distance) > kHalfDiagonal * edge) return distance > 0 ? points * points * points : 0;
  const int parts = points % 2 == 0 ? 2 : 3;
  int outside = 0;
  for (int n = 0; n < parts * parts * parts; ++n) {
    const Vec3i at(n % parts, n / parts % parts, n / parts / parts);
    const Vec3 offset = (at.cast<double>() + Vec3::Constant(0.5)) / parts - Vec3::Constant(0.5);
    outside += points_outside(solid, center + edge * offset, edge / parts, points / parts);
  }
  return outside;
}

/// The fraction of a voxel that lies outside a solid, from 12³ points.
inline double fraction_outside(const Solid& solid, const Vec3& center, double voxel) {
  constexpr int kPoints = 12;
  return static_cast<double>(points_outside(solid, center, voxel, kPoints)) / (kPoints * kPoints * kPoints);
}

/// A block that can be reamed; its top face is z = 0, its middle x = y = 0.
struct Block {
  Block(const Vec3& size_mm, double voxel_mm, const std::function<double(const Vec3&)>& density) {
    VoxelGrid grid;
    grid.voxel_mm = voxel_mm;
    const Vec3i voxels = (size_mm / voxel_mm).array().round().cast<int>();
    grid.dims = voxels + Vec3i::Constant(2 * kMargin);
    grid.origin_mm = Vec3(-size_mm.x() / 2, -size_mm.y() / 2, -size_mm.z()) - Vec3::Constant(kMargin * voxel_mm);
    after = FilledVoxmap(grid);
    for (int k = 0; k < voxels.z(); ++k) {
      for (int j = 0; j < voxels.y(); ++j) {
        for (int i = 0; i < voxels.x(); ++i) {
          const Vec3i voxel = Vec3i(i, j, k) + Vec3i::Constant(kMargin);
          const Vec3 center = grid.center_mm(voxel);
          after.grade.set(voxel, DensityMapping::grade_from_density(density(center)));
        }
      }
    }
    before = after.fill;
  }
  Block(const Vec3& size_mm, double voxel_mm, double density_g_cm3)
      : Block(size_mm, voxel_mm, [=](const Vec3&) { return density_g_cm3; }) {}

  /// Takes the solid away, partly filled voxels and all.
  void ream(const Solid& solid) {
    for_each_bone_voxel(after, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t fill) {
      const Vec3 center = after.grid.center_mm(voxel);
      const double left = fraction_outside(solid, center, after.grid.voxel_mm);
      const auto most = static_cast<std::uint16_t>(std::lround(left * FillBricks::kWhole));
      if (most < fill) changed.emplace_back(voxel, most);
    });
    for (const auto& [voxel, fill] : changed) after.fill.set(voxel, fill);
    changed.clear();
  }
  /// As ream(), but a voxel that is touched goes whole.
  void ream_whole_voxels(const Solid& solid) {
    ream(solid);
    for_each_bone_voxel(after, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t fill) {
      if (fill < FillBricks::kWhole) changed.emplace_back(voxel, std::uint16_t{0});
    });
    for (const auto& [voxel, fill] : changed) after.fill.set(voxel, fill);
    changed.clear();
  }

  [[nodiscard]] BoneView reamed() const { return {after, after.fill, before}; }
  [[nodiscard]] BoneMetrics measure(const Rigid& bone_from_tool = Rigid::Identity(),
                                    const MetricSettings& settings = {}, const BoneAxes& axes = {},
                                    const TriangleMesh* implant_mesh = nullptr) const {
    return measure_bone(reamed(), bone_from_tool, axes, settings, implant_mesh);
  }

  static constexpr int kMargin = 4;  ///< voxels of air all round
  FilledVoxmap after;
  FillBricks before;
  std::vector<std::pair<Vec3i, std::uint16_t>> changed;
};

/// A spherical cap of `radius`, its lowest point at `apex`.
inline Solid cap(const Vec3& apex, double radius) {
  return ball(apex + radius * Vec3::UnitZ(), radius);
}

}  // namespace reamsim::test
