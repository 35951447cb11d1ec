#pragma once

#include <utility>

#include "sim/base/stopwatch.h"
#include "sim/collide/detector.h"
#include "sim/collide/serial_state.h"

namespace reamsim {

/// The reference of `implicit`: every voxel in turn against the tool's solid of revolution, in plain C++. No culling,
/// so that it also checks the VOI.
class SerialImplicitDetector final : public Detector {
 public:
  explicit SerialImplicitDetector(SerialState& state) : state_(state) {}
  void detect(int slot) override;
  std::vector<double> take_seconds() override { return std::exchange(seconds_, {}); }

 private:
  SerialState& state_;
  std::vector<double> seconds_;
};

}  // namespace reamsim
