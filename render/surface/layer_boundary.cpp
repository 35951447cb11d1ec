// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/layer_boundary.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace reamsim {
LayerBoundary::LayerBoundary(const Voxmap& voxmap, const UnreamedSurface& unreamed, const Vec3& a, const Vec3& b,
                             const Vec3& c)
    : voxmap_(voxmap) {
  constexpr double kMargin_voxels = 3;
  const Vec3 normal = (b - a).cross(c - a).normalized();
  const double reach = voxmap.layers->cortical_mm / voxmap.grid.voxel_mm + kMargin_voxels;
  std::vector<Vec3> points;
  for (const Eigen::Vector3f& p : unreamed.surface().points) {
    if (std::abs(normal.dot(p.cast<double>() - a)) < reach) points.emplace_back(p.cast<double>());
  }
  const std::vector<Eigen::AlignedBox3d> boxes(points.begin(), points.end());
  if (!points.empty()) surface_.emplace(points.begin(), points.end(), boxes.begin(), boxes.end());
}

bool LayerBoundary::near(const Vec3& point) const {
  const Vec3i base = point.array().floor().cast<int>();
  std::uint8_t found = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3i voxel = base + Vec3i(i & 1, i >> 1 & 1, i >> 2);
    if (!voxmap_.grid.contains(voxel)) continue;
    const std::uint8_t grade = voxmap_.grade.get(voxel);
    if (grade == 0 || grade == found) continue;
    if (found != 0) return true;
    found = grade;
  }
  return false;
}

double LayerBoundary::density_at(const Vec3& point, double blend_voxels) const {
  const BoneLayers& layers = *voxmap_.layers;
  if (!surface_) return layers.trabecular_g_cm3;
  PointDistance from{point};
  const double depth = std::sqrt(Eigen::BVMinimize(*surface_, from));
  const double beyond = depth - layers.cortical_mm / voxmap_.grid.voxel_mm;
  const double trabecular = std::clamp(beyond / blend_voxels + 0.5, 0.0, 1.0);
  return layers.cortical_g_cm3 + trabecular * (layers.trabecular_g_cm3 - layers.cortical_g_cm3);
}

}  // namespace reamsim
