#pragma once

#include "sim/engine/common/detector.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/dense/dense_state.h"

namespace reamsim {

/// The paper's narrow phase on OpenCL (§3.5): one work-item per shell point, which is kept as a Morton code.
class DirectDetector final : public Detector {
 public:
  /// `work_group` items per group; the result does not depend on it.
  DirectDetector(const cl::Device& device, const DenseState& state, const DeviceBatch& batch, const PointShell& shell,
                 std::size_t work_group);
  void detect(int slot) override;
  std::vector<double> take_seconds() override { return kernel_.take_seconds(); }

 private:
  std::size_t points_;
  cl::Buffer<cl_uint> codes_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
