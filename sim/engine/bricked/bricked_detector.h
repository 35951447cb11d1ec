#pragma once

#include "sim/engine/bricked/bricked_options.h"
#include "sim/engine/common/detector.h"
#include "sim/engine/common/device_batch.h"

namespace reamsim {

/// Cells of shell points against bricks of voxels; see kernels/detect_bricked.cl.
class BrickedDetector final : public Detector {
 public:
  BrickedDetector(const cl::Device& device, BrickedState& state, const DeviceBatch& batch,
                  const BrickedOptions& options);
  void detect(int slot) override;
  std::vector<double> take_seconds() override { return kernel_.take_seconds(); }

 private:
  std::size_t items_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
