#pragma once

#include <vector>

namespace reamsim {

/// Answers, for each voxel of the contact list: how much goes, what force does that take, what is left? Adds to the
/// sums of `slot` and empties the contact list. The same for every detector.
class Erosion {
 public:
  virtual ~Erosion() = default;
  virtual void cut(int slot) = 0;
  /// Seconds that each slot took since the last take_seconds(). Call it when the engine has finished.
  virtual std::vector<double> take_seconds() = 0;
};

}  // namespace reamsim
