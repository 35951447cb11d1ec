// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/sweep.h"

namespace reamsim {

/// What a worker says of a run: on one line the letter of the outcome, a space, and the text.
struct WorkerAnswer {
  enum class Outcome : char { done = 'd', failed = 'f', wrong_input = 'e', busy = 'b', interrupted = 'i' };

  std::size_t run = 0;  ///< index in the plan
  Outcome outcome = Outcome::done;
  /// The message of a failure; of a check, its RunEstimate as JSON; of a run, whether it was continued, or "".
  std::string text;

  [[nodiscard]] bool has_failed() const {
    return outcome != Outcome::done && outcome != Outcome::busy && outcome != Outcome::interrupted;
  }
};

/// What a run would take.
struct RunEstimate {
  double load_s = 0;
  double simulate_s = 0;
  std::size_t memory_bytes = 0;  ///< of the process, without pictures
  std::int64_t frames = 0;
  std::vector<std::string> warnings;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunEstimate, load_s, simulate_s, memory_bytes, frames, warnings)

/// Distributes runs (indices in the plan) over `jobs` processes of this program, which divide the processors among
/// them; each loads OpenCL and a bone that several runs share once. They simulate into the study's folder `dir`, or,
/// where it is "", check. Calls `answered` for each run. A worker that ends by itself fails its run and is replaced.
/// Returns false where stop_requested() ended the work; workers have then ended, and saved what they could. Throws
/// RunError where no worker can be started.
bool work_on(const SweepRuns& sweep, const std::vector<std::size_t>& runs, const SweepOptions& options,
             const std::string& dir, int jobs, const std::function<void(const WorkerAnswer&)>& answered);

}  // namespace reamsim
