#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "sim/engine/common/detector.h"
#include "sim/engine/serial/serial_state.h"

namespace reamsim {

/// Appends to `state.contacts` the voxels that the tool touches in the substep of slot `slot`.
using FindContacts = std::function<void(SerialState& state, int slot)>;

/// The references, in plain C++: the voxels that hold a shell point, each once. No culling, so that it also checks the
/// VOI.
FindContacts find_by_points(const SerialState& state);
/// Of `implicit`: every voxel in turn against the tool's solid of revolution. No culling either.
void find_by_profile(SerialState& state, int slot);
/// Of `exact`, which clips what it is given: every voxel of bone in the tool's box.
void find_in_tool_box(SerialState& state, int slot);

/// Runs one of them.
class SerialDetector final : public Detector {
 public:
  SerialDetector(SerialState& state, FindContacts find) : state_(state), find_(std::move(find)) {}
  void detect(int slot) override;
  std::vector<double> take_seconds() override { return std::exchange(seconds_, {}); }

 private:
  SerialState& state_;
  FindContacts find_;
  std::vector<double> seconds_;
};

}  // namespace reamsim
