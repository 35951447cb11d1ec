#pragma once

#include "sim/bone/bone_vdb.h"
#include "sim/collide/dense_state.h"

namespace reamsim {

/// Puts single voxels of a dense bone back, so that a benchmark need not upload the whole bone before each repetition.
class VoxelRestorer {
 public:
  VoxelRestorer(const cl::Device& device, DenseState& state);
  /// Gives the voxels of `gone` what `voxmap` has of them. Returns when the device has done it.
  void restore(const Voxmap& voxmap, const RemovedFrames& gone);

 private:
  const cl::Device& device_;
  bool hu_;  ///< voxels are kept as HU
  cl::Program program_;
  cl::Kernel kernel_;
};

}  // namespace reamsim
