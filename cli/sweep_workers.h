// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "cli/sweep.h"

namespace reamsim {

/// What workers do with the runs of a study.
enum class WorkerTask { simulate, check };

/// The letter of a failure whose cause is the input.
inline constexpr char kWrongInput = 'e';

/// What a worker says of a run.
struct WorkerAnswer {
  enum class Outcome { done, failed, busy, interrupted };

  std::size_t run = 0;  ///< index in the plan
  Outcome outcome = Outcome::done;
  bool wrong_input = false;  ///< of a failure: the scenario or a file is wrong
  /// The message of a failure; of a check, its estimates (RunEstimate); of a run, whether it was continued, or "".
  std::string text;
};

/// Distributes runs over processes of this program, each of which loads OpenCL and a bone that several runs share once.
class SweepWorkers {
 public:
  /// `jobs`: number of processes, which divide the processors among them.
  SweepWorkers(const SweepOptions& options, std::string dir, WorkerTask task, int jobs);

  /// Has these runs (indices in the plan) done, and calls `answered` for each. A worker that ends by itself fails its
  /// run and is replaced. Returns false where stop_requested() ended the work; workers have then ended, and saved what
  /// they could. Throws RunError where no worker can be started.
  bool work(const SweepRuns& sweep, const std::vector<std::size_t>& runs,
            const std::function<void(const WorkerAnswer&)>& answered);

 private:
  SweepOptions options_;
  std::string dir_;
  WorkerTask task_;
  int jobs_;
};

}  // namespace reamsim
