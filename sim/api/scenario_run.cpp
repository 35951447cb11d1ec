// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/api/reamsim/simulation.h"
#include "sim/api/state_parts.h"
#include "sim/run/run_scenario.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

/// Passes a run on to the functions of the caller, and collects its warnings.
class CallerMonitor final : public RunMonitor {
 public:
  explicit CallerMonitor(const RunOptions& options) : options_(options) {}

  void take(const Diagnostics& report) override {
    warnings.insert(warnings.end(), report.warnings.begin(), report.warnings.end());
  }
  void progress(std::int64_t done, std::int64_t total) override {
    if (options_.progress) options_.progress(done, total);
  }
  [[nodiscard]] bool stop_requested() override { return options_.stop && options_.stop(); }

  std::vector<std::string> warnings;

 private:
  const RunOptions& options_;
};

}  // namespace

RunResults run_scenario(const std::string& scenario, const RunOptions& options) {
  return guarded([&]() -> RunResults {
    RunRequest request;
    request.scenario = parse_scenario(scenario, options.set);
    request.dir = options.dir.empty() ? results_dir(request.scenario) : options.dir;
    request.overwrite = options.overwrite;
    request.resume = options.resume;
    RunResources resources;
    CallerMonitor monitor(options);
    try {
      run_scenario(request, resources, monitor, nullptr);
    } catch (const Interrupted& interrupted) {
      throw Stopped(interrupted.what());
    }
    return {request.dir, std::move(monitor.warnings)};
  });
}

}  // namespace reamsim
