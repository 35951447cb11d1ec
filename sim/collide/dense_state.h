#pragma once

#include "kernels/shared.h"
#include "sim/collide/dense_plan.h"
#include "sim/collide/profile_table.h"

namespace reamsim {

/// What lives on the device between detect and cut, beside the batch, in the paper's layout: the bone as a dense 8-bit
/// array, the shell at 4 bytes a point; and beside them a claim bit per voxel and the contact list.
struct DenseState {
  cl::Buffer<cl_uchar> bone;   ///< grade, 0 = air or gone
  cl::Buffer<cl_ushort> fill;  ///< per voxel, or one dummy where every voxel is whole
  bool has_fill = false;
  cl::Buffer<cl_uint> claims;
  cl::Buffer<cl_uint> codes;
  std::size_t points = 0;
  DeviceProfile profile;
  cl::Buffer<cl_uint> contacts;
};

/// Uploads bone and tool. Throws RunError when the device has no room after all.
DenseState make_dense_state(const cl::Device& device, const DensePlan& plan, const Voxmap& voxmap, const Tool& tool);

/// Writes the bone as `voxmap` has it. Throws RunError where it is not the bone that `plan` was made for.
void upload_bone(const cl::Device& device, const DensePlan& plan, const Voxmap& voxmap, DenseState& state);

}  // namespace reamsim
