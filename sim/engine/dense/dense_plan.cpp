// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/dense/dense_plan.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/read_back.h"
#include "sim/tool/morton.h"

namespace reamsim {

namespace {

/// Size of the list of removed voxels; larger scenes read results back more often.
constexpr std::size_t kRemovedRoom = 4'000'000;

constexpr std::size_t kMaxVoxels = std::size_t{1} << 32;

/// Bound of the number of voxels with centres in the tool, in any pose: the volume of the tool's box, extended by half
/// a voxel's diagonal on every side.
std::size_t voxels_in_tool(const Profile& profile, double voxel_mm) {
  const Aabb box = profile.bounds();
  const Vec3 grown = (box.max - box.min) / voxel_mm + Vec3::Constant(std::sqrt(3.0));
  return static_cast<std::size_t>(std::ceil(std::min(grown.prod(), static_cast<double>(kMaxVoxels))));
}

}  // namespace

std::size_t DensePlan::bone_bytes() const {
  return voxels * (layout == VoxelLayout::flagged_hu ? sizeof(cl_float) : sizeof(cl_uchar));
}

std::size_t DensePlan::claim_bytes() const {
  constexpr std::size_t kBitsPerWord = 32, kFlagsPerWord = 4;
  if (layout == VoxelLayout::claimed_grade) return sizeof(cl_uint) * (voxels / kBitsPerWord + 1);
  if (layout == VoxelLayout::flagged_hu) return sizeof(cl_uint) * (voxels / kFlagsPerWord + 1);
  return 0;
}

std::size_t DensePlan::fill_bytes() const {
  return fill ? sizeof(cl_ushort) * voxels : 0;
}

std::size_t DensePlan::shell_bytes() const {
  const std::size_t code = wide_codes ? sizeof(cl_ulong) : sizeof(cl_uint);
  return points * (layout == VoxelLayout::flagged_hu ? 3 * sizeof(cl_float) : code);
}

std::size_t DensePlan::bytes() const {
  return bone_bytes() + claim_bytes() + fill_bytes() + shell_bytes() + sizeof(cl_uint) * contacts +
         DeviceBatch::bytes(removed_list());
}

std::size_t DensePlan::largest_bytes() const {
  return std::max({bone_bytes(), claim_bytes(), fill_bytes(), shell_bytes(), sizeof(cl_uint) * contacts,
                   sizeof(RemovedVoxel) * removed});
}

DensePlan plan_dense(EngineKind engine, const BoneView& bone, const Tool& tool, bool wear) {
  DensePlan plan;
  if (engine == EngineKind::octree) plan.layout = VoxelLayout::flagged_hu;
  if (engine == EngineKind::implicit) plan.layout = VoxelLayout::bare_grade;
  const bool has_shell = plan.layout != VoxelLayout::bare_grade;
  plan.voxels = static_cast<std::size_t>(bone.voxmap.grid.size());
  plan.bone_voxels = static_cast<std::size_t>(bone.voxmap.grade.count());
  plan.points = has_shell ? tool.shell.codes.size() : 0;
  plan.wide_codes = tool.shell.resolution > kNarrowResolution;
  plan.fill = wear || partly_filled(bone.fill);
  plan.contacts =
      std::min(plan.bone_voxels, has_shell ? plan.points : voxels_in_tool(tool.profile, bone.voxmap.grid.voxel_mm));
  plan.removed = std::min(plan.bone_voxels, std::max(kRemovedRoom, plan.contacts));
  return plan;
}

void require_fit(const DensePlan& plan, const cl::DeviceInfo& device, double voxel_mm) {
  const auto fraction = [](std::size_t need, std::size_t have) {
    return static_cast<double>(need) / static_cast<double>(std::max<std::size_t>(1, have));
  };
  const double most = std::max({fraction(plan.voxels, kMaxVoxels), fraction(plan.bytes(), device.global_memory_bytes),
                                fraction(plan.largest_bytes(), device.max_allocation_bytes)});
  if (most <= 1) return;
  // Memory is inversely proportional to the cube of the voxel size; the margin covers the rounding to whole voxels.
  constexpr double kMargin = 1.02;
  const std::string fits =
      fmt::format("a bone.voxel_mm of about {:.3g} or more would fit", voxel_mm * std::cbrt(most) * kMargin);
  throw InputError({}, "bone.voxel_mm",
                   "found a voxmap of " + std::to_string(plan.voxels) + " voxels; a dense engine supports at most " +
                       std::to_string(kMaxVoxels) + "; it needs " + megabytes(plan.bytes()) + " on the device and " +
                       megabytes(plan.largest_bytes()) + " of it in one allocation; " + device.name + " has " +
                       megabytes(device.global_memory_bytes) + " in total and at most " +
                       megabytes(device.max_allocation_bytes) + " in one allocation",
                   std::string(fits) + ", or engine.type: bricked, which stores only bricks with bone");
}

}  // namespace reamsim
