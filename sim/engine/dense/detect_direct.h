#pragma once

#include "sim/engine/common/device_batch.h"
#include "sim/engine/dense/dense_state.h"
#include "sim/engine/dense/detection.h"

namespace reamsim {

/// The paper's narrow phase on OpenCL (§3.5): one work-item per shell point, which is kept as a Morton code.
class DetectDirect final : public Detection {
 public:
  /// `work_group` items per group; the result does not depend on it.
  DetectDirect(const cl::Device& device, const DenseState& state, const DeviceBatch& batch, const PointShell& shell,
               std::size_t work_group);
  void enqueue(int slot) override;
  std::vector<double> take_seconds() override { return kernel_.take_seconds(); }

 private:
  /// The parameters of the kernel, in its order.
  enum class Argument : cl_uint {
    codes,
    point_count,
    args,
    substep,
    bone,
    claims,
    contacts,
    contact_count,
    sums,
    edges,
    numbers,
    lists,
    grid
  };

  std::size_t points_;
  cl::Buffer<cl_uint> codes_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
