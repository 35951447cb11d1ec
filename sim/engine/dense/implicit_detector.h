#pragma once

#include "sim/engine/common/detector.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/voxel_box.h"
#include "sim/engine/dense/dense_state.h"

namespace reamsim {

/// The narrow phase of Yau et al. on OpenCL, as Faieghi et al. (2020, §4.3.2) rebuilt it: one work-item per voxel of
/// the VOI against the tool's solid of revolution. The state's layout is bare_grade.
class ImplicitDetector final : public Detector {
 public:
  /// `work_group` items per group; the result does not depend on it.
  ImplicitDetector(const cl::Device& device, const DenseState& state, const DeviceBatch& batch, const Profile& profile,
                   const VoxelBox& bone, std::size_t work_group);
  void detect(int slot) override;
  std::vector<double> take_seconds() override { return kernel_.take_seconds(); }

 private:
  const DeviceBatch& batch_;
  Aabb tool_box_;  ///< T, mm
  VoxelBox bone_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
