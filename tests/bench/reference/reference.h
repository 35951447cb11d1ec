#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kernels/cut_law.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/tool.h"

namespace reamsim::reference {

/// Instruction sets that the passes are compiled for.
enum class Target { plain, avx2, avx512 };
const char* name_of(Target target);
/// Those that this processor has, the fastest last.
std::vector<Target> usable_targets();

/// What `bricked` is measured against: its frame in C++ without OpenCL, over memory of its own. Energetic law, erosion
/// `remove`, and bone whose voxels are whole.
class Reference {
 public:
  /// `threads`: with the caller's. Throws RunError on other settings of cutting, or bone that is partly gone.
  Reference(const BoneView& bone, const Tool& tool, const CuttingSettings& cutting, Target target, unsigned threads);
  ~Reference();

  /// Collides and cuts; the sums are those that the engine's batch gives for the substep.
  SubstepSums run(const SubstepArgs& args);
  /// The voxels that went in the last run(), block by block, in no order.
  [[nodiscard]] std::vector<RemovedBlock> removed() const;
  /// Their indices in the voxmap's grid, ascending.
  [[nodiscard]] std::vector<std::int64_t> removed_voxels() const;
  /// Puts them back.
  void restore();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace reamsim::reference
