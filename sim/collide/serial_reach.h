#pragma once

#include <utility>

#include "sim/base/stopwatch.h"
#include "sim/collide/detector.h"
#include "sim/collide/serial_state.h"

namespace reamsim {

/// The detector of the reference for `exact`: every voxel of bone in the tool's box, in plain C++.
class SerialReach final : public Detector {
 public:
  explicit SerialReach(SerialState& state) : state_(state) {}
  void detect(int slot) override;
  std::vector<double> take_seconds() override { return std::exchange(seconds_, {}); }

 private:
  SerialState& state_;
  std::vector<double> seconds_;
};

}  // namespace reamsim
