#pragma once

#include "kernels/shared.h"
#include "sim/engine/common/profile_table.h"
#include "sim/engine/dense/dense_plan.h"
#include "sim/engine/dense/hu_scale.h"

namespace reamsim {

/// What lives on the device between detect and cut, beside the batch and the detector's own shell: the bone as a dense
/// array in the plan's layout, claims, the contact list and the tool's profile.
struct DenseState {
  cl::Buffer<cl_uchar> grades;      ///< 0 = air or gone; unless the layout is flagged_hu
  cl::Buffer<cl_float> hu;          ///< HuScale::of_air = air or gone; where the layout is flagged_hu
  HuScale scale{DensityMapping{}};  ///< of `hu`
  cl::Buffer<cl_ushort> fill;       ///< per voxel, or one dummy where every voxel is whole
  bool has_fill = false;
  cl::Buffer<cl_uint> claims;  ///< a bit or a byte per voxel, or one dummy word
  DeviceProfile profile;
  cl::Buffer<cl_uint> contacts;
};

/// Uploads bone and profile. Throws RunError when the device has no room after all, InputError when the layout is
/// flagged_hu and floats cannot tell the voxmap's grades apart by their HU.
DenseState make_dense_state(const cl::Device& device, const DensePlan& plan, const BoneView& bone, const Tool& tool);

/// Writes the bone as `voxmap` has it. Throws RunError where it is not the bone that `plan` was made for.
void upload_bone(const cl::Device& device, const DensePlan& plan, const BoneView& bone, DenseState& state);

}  // namespace reamsim
