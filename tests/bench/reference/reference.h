// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <vector>

#include "kernels/cut_law.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/tool.h"
#include "tests/bench/reference/targets.h"

namespace reamsim::reference {

/// What `bricked` is measured against: its frame in C++ without OpenCL, over memory of its own. Energetic law, erosion
/// `remove`, and bone whose voxels are whole.
class Reference {
 public:
  /// `threads`: with the caller's. Throws RunError on other settings of cutting, or bone that is partly
  /// removed.
  Reference(const BoneView& bone, const Tool& tool, const CuttingSettings& cutting, Target target, unsigned threads);
  ~Reference();
  Reference(const Reference&) = delete;
  Reference& operator=(const Reference&) = delete;

  /// Collides and cuts; the sums are those that the engine's batch gives for the substep.
  SubstepSums run(const SubstepArgs& args);
  /// The voxels that the last run() removed, block by block, in no order.
  [[nodiscard]] std::vector<RemovedBlock> removed() const;
  /// Their indices in the voxmap's grid, ascending.
  [[nodiscard]] std::vector<std::int64_t> removed_voxels() const;
  /// Restores them.
  void restore();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace reamsim::reference
