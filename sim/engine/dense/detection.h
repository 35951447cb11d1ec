#pragma once

#include <vector>

namespace reamsim {

/// A narrow phase over a dense voxmap: puts the voxels that the tool touches in a substep on the contact list, each
/// once, and changes nothing that the cut will write.
class Detection {
 public:
  virtual ~Detection() = default;
  /// Enqueues the substep in `slot` of the batch.
  virtual void enqueue(int slot) = 0;
  /// Seconds that each slot took since the last call. Call it when the queue has finished.
  virtual std::vector<double> take_seconds() = 0;
};

}  // namespace reamsim
