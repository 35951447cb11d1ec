#pragma once

#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/voxel_box.h"
#include "sim/engine/dense/dense_state.h"
#include "sim/engine/dense/detection.h"

namespace reamsim {

/// The narrow phase of Yau et al. on OpenCL, as Faieghi et al. (2020, §4.3.2) rebuilt it: one work-item per voxel of
/// the VOI against the tool's solid of revolution. The state's layout is bare_grade.
class DetectImplicit final : public Detection {
 public:
  /// `work_group` items per group; the result does not depend on it.
  DetectImplicit(const cl::Device& device, const DenseState& state, const DeviceBatch& batch, const Profile& profile,
                 const VoxelBox& bone, std::size_t work_group);
  void enqueue(int slot) override;
  std::vector<double> take_seconds() override { return kernel_.take_seconds(); }

 private:
  /// The parameters of the kernel, in its order.
  enum class Argument : cl_uint {
    args,
    substep,
    voi_min,
    voi_size,
    bone,
    contacts,
    contact_count,
    edges,
    numbers,
    lists,
    grid
  };

  const DeviceBatch& batch_;
  Aabb tool_box_;  ///< T, mm
  VoxelBox bone_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
