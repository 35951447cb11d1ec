#include "sim/collide/dense_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sim/base/error.h"
#include "sim/collide/dense_bone.h"
#include "sim/collide/device_batch.h"

namespace reamsim {

namespace {

/// Room for removed voxels that a batch may fill; larger scenes read results back more often instead.
constexpr std::size_t kRemovedRoom = 4'000'000;

constexpr std::size_t kMostVoxels = std::size_t{1} << 32;

std::string megabytes(std::size_t bytes) {
  return std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

}  // namespace

std::size_t DensePlan::bytes() const {
  return voxels + (fill ? sizeof(cl_ushort) * voxels : 0) + voxels / 8 + sizeof(cl_uint) * points +
         sizeof(cl_uint) * contacts + DeviceBatch::bytes(removed_list());
}

std::size_t DensePlan::largest_bytes() const {
  return std::max({voxels, fill ? sizeof(cl_ushort) * voxels : 0, sizeof(cl_uint) * points, sizeof(cl_uint) * contacts,
                   sizeof(RemovedVoxel) * removed});
}

DensePlan plan_dense(const Voxmap& voxmap, const Tool& tool, bool wear) {
  DensePlan plan;
  plan.voxels = static_cast<std::size_t>(voxmap.grid.size());
  plan.unreamed = count_unreamed(voxmap);
  plan.points = tool.shell.codes.size();
  plan.fill = wear || partly_filled(voxmap);
  plan.contacts = std::min(plan.unreamed, plan.points);
  plan.removed = std::min(plan.unreamed, std::max(kRemovedRoom, plan.contacts));
  return plan;
}

void require_fit(const DensePlan& plan, const cl::DeviceInfo& device, double voxel_mm) {
  const auto share = [](std::size_t need, std::size_t have) {
    return static_cast<double>(need) / static_cast<double>(std::max<std::size_t>(1, have));
  };
  const double most = std::max({share(plan.voxels, kMostVoxels), share(plan.bytes(), device.global_memory_bytes),
                                share(plan.largest_bytes(), device.max_allocation_bytes)});
  if (most <= 1) return;
  // Memory grows with the inverse cube of the voxel; a little more, because the bone is rounded to whole voxels.
  constexpr double kMargin = 1.02;
  char fits[96];
  std::snprintf(fits, sizeof fits, "a bone.voxel_mm of about %.3g or more would fit",
                voxel_mm * std::cbrt(most) * kMargin);
  throw InputError({}, "bone.voxel_mm",
                   "found a voxmap of " + std::to_string(plan.voxels) + " voxels, which needs " +
                       megabytes(plan.bytes()) + " on the device and " + megabytes(plan.largest_bytes()) +
                       " of it in one piece; " + device.name + " has " + megabytes(device.global_memory_bytes) +
                       " and allocates at most " + megabytes(device.max_allocation_bytes) + " in one piece",
                   fits);
}

}  // namespace reamsim
