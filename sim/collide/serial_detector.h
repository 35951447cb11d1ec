#pragma once

#include <utility>
#include <vector>

#include "sim/base/stopwatch.h"
#include "sim/collide/detector.h"
#include "sim/collide/serial_state.h"

namespace reamsim {

/// The reference: every shell point in turn, in plain C++. No culling, so that it also checks the VOI.
class SerialDetector final : public Detector {
 public:
  explicit SerialDetector(SerialState& state) : state_(state), claimed_(state.bone.size(), false) {}
  void detect(int slot) override;
  std::vector<double> take_seconds() override { return std::exchange(seconds_, {}); }

 private:
  SerialState& state_;
  std::vector<bool> claimed_;
  std::vector<double> seconds_;
};

}  // namespace reamsim
