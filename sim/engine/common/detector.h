#pragma once

#include <vector>

namespace reamsim {

/// Answers: which voxels does the tool touch in this substep? The touched voxels go to the engine's contact list, each
/// once; nothing that the cut will write is changed. `slot` names the substep's arguments and sums in the batch.
class Detector {
 public:
  virtual ~Detector() = default;
  virtual void detect(int slot) = 0;
  /// Seconds that each slot took since the last take_seconds(). Call it when the engine has finished.
  virtual std::vector<double> take_seconds() = 0;
};

}  // namespace reamsim
