// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/broad_phase.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

/// Rounding allowance for axes that are cross products of nearly parallel edges.
constexpr double kParallelEpsilon = 1e-12;
/// Rounding allowance of the voxel box: more than the error of the kernels' single precision, voxels.
constexpr double kVoxelSlack = 0.05;

}  // namespace

bool boxes_overlap(const Aabb& a, const Aabb& b, const Rigid& a_from_b) {
  const Mat3 rotation = a_from_b.linear();
  const Mat3 abs_rotation = rotation.cwiseAbs().array() + kParallelEpsilon;
  const Vec3 offset = a_from_b * b.center() - a.center();
  const Vec3 half_a = a.half(), half_b = b.half();

  if ((offset.cwiseAbs().array() > (half_a + abs_rotation * half_b).array()).any()) return false;
  const Vec3 offset_in_b = rotation.transpose() * offset;
  if ((offset_in_b.cwiseAbs().array() > (half_b + abs_rotation.transpose() * half_a).array()).any()) return false;

  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double reach_a = half_a[i1] * abs_rotation(i2, j) + half_a[i2] * abs_rotation(i1, j);
      const double reach_b = half_b[j1] * abs_rotation(i, j2) + half_b[j2] * abs_rotation(i, j1);
      const double distance = std::abs(offset[i2] * rotation(i1, j) - offset[i1] * rotation(i2, j));
      if (distance > reach_a + reach_b) return false;
    }
  }
  return true;
}

std::optional<Aabb> volume_of_interest(const Aabb& tool, const Aabb& bone, const Rigid& tool_from_bone) {
  const Vec3 center = tool_from_bone * bone.center();
  const Vec3 half = tool_from_bone.linear().cwiseAbs() * bone.half();
  const Aabb voi{tool.min.cwiseMax(center - half), tool.max.cwiseMin(center + half)};
  return voi.empty() ? std::nullopt : std::optional(voi);
}

std::optional<Aabb> broad_phase(const Aabb& tool, const Aabb& bone, const Rigid& tool_from_bone) {
  if (!boxes_overlap(tool, bone, tool_from_bone)) return std::nullopt;
  return volume_of_interest(tool, bone, tool_from_bone);
}

VoxelBox voxel_voi(const SubstepArgs& args, const Aabb& tool_box, const VoxelBox& bone) {
  // Eigen reads the row-major matrix as its transpose, which up to the voxel size is the inverse.
  const Eigen::Map<const Mat3> transposed(args.tool_from_voxel);
  const Mat3 voxel_from_tool = transposed / transposed.row(0).squaredNorm();
  const Vec3 center = voxel_from_tool * (tool_box.center() - Eigen::Map<const Vec3>(args.tool_origin));
  const Vec3 half = voxel_from_tool.cwiseAbs() * tool_box.half() + Vec3::Constant(kVoxelSlack);
  VoxelBox voi;
  for (int i = 0; i < 3; ++i) {
    // Clamped before the conversion: the voxel of a distant tool overflows an int.
    const double low = std::ceil(center[i] - half[i]), high = std::floor(center[i] + half[i]);
    voi.first[i] = static_cast<int>(std::clamp(low, double(bone.first[i]), bone.last[i] + 1.0));
    voi.last[i] = static_cast<int>(std::clamp(high, bone.first[i] - 1.0, double(bone.last[i])));
  }
  return voi;
}

}  // namespace reamsim
