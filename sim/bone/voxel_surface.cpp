// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxel_surface.h"

#include "kernels/cube_fraction.h"

namespace reamsim {

namespace {

constexpr int kHalvings = 24;
constexpr double kLeastGradient = 1e-6;

/// Gradient of the bone's fraction over the 3×3×3 voxels around one. The weights 1, 2, 1 across each axis make it that
/// of a plane to within a few degrees.
Vec3 fraction_gradient(const BoneView& bone, const Vec3i& voxel) {
  Vec3 out = Vec3::Zero();
  for_each_voxel(Vec3i::Constant(-1), Vec3i::Ones(), [&](const Vec3i& step) {
    const double fraction = bone_fraction(bone, voxel + step);
    if (fraction == 0) return;
    for (int axis = 0; axis < 3; ++axis) {
      const int across = step.cwiseAbs().sum() - std::abs(step[axis]);
      out[axis] += fraction * step[axis] * (across == 0 ? 4 : across == 1 ? 2 : 1);
    }
  });
  return out;
}

/// Distance of the plane from the centre of a unit cube of which it leaves `fraction` on its inner side.
double plane_offset(const Vec3& normal, double fraction) {
  const float n[3] = {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z())};
  double low = -RS_CLIP_REACH, high = RS_CLIP_REACH;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    const double inside = 1 - double{rs_outside_fraction(n, static_cast<float>(-middle))};
    (inside < fraction ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double bone_fraction(const BoneView& bone, const Vec3i& voxel) {
  const Voxmap& voxmap = bone.voxmap;
  if (!voxmap.grid.contains(voxel) || voxmap.grade.get(voxel) == 0) return 0;
  return static_cast<double>(bone.fill.get(voxel)) / FillBricks::kWhole;
}

std::optional<VoxelPlane> voxel_plane(const BoneView& bone, const Vec3i& voxel, const Vec3& fallback) {
  const double fraction = bone_fraction(bone, voxel);
  if (fraction >= 1) return std::nullopt;
  const Vec3 gradient = fraction_gradient(bone, voxel);
  const double length = gradient.norm();
  const Vec3 normal = length > kLeastGradient ? Vec3(-gradient / length) : fallback;
  return VoxelPlane{normal, bone.voxmap.grid.voxel_mm * plane_offset(normal, fraction)};
}

}  // namespace reamsim
