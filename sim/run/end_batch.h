// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/error.h"
#include "sim/run/frame_stepper.h"
#include "sim/run/simulation.h"

namespace reamsim {

/// Saves the state that `state()` gives where that is due, and ends the run where that is asked for. Throws
/// Interrupted.
template <class State>
void end_batch(FrameStepper& stepper, const RunControl& control, const State& state) {
  stepper.begin_batch();
  const bool stop = control.stop();
  if (stop || control.save_due()) {
    stepper.read_fill();
    control.save(state());
  }
  if (stop) throw Interrupted();
}

}  // namespace reamsim
