#pragma once

#include "sim/collide/bricked_state.h"
#include "sim/collide/detector.h"
#include "sim/collide/device_batch.h"

namespace reamsim {

/// How the kernels of `bricked` run; the results do not depend on it.
struct BrickedOptions {
  KernelShape shape = KernelShape::cpu;
  std::size_t work_group = 1;
  bool culling = true;  ///< pass over cells that cannot touch; off only to prove that it changes nothing
};

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
