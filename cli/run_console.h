// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "cli/console.h"
#include "cli/outputs.h"
#include "sim/run/run_scenario.h"

namespace reamsim {

/// A run on the terminal: its lines and progress, and the signals that interrupt it.
class RunConsole : public RunMonitor {
 public:
  explicit RunConsole(const Console& console) : console_(console) {}

  void say(const std::string& line) override;
  void take(const Diagnostics& report) override;
  void progress(std::int64_t done, std::int64_t total) override;
  [[nodiscard]] bool stop_requested() override { return reamsim::stop_requested(); }
  [[nodiscard]] std::shared_ptr<void> saving() override { return std::make_shared<StopGrace>(); }
  [[nodiscard]] std::shared_ptr<void> on_forced_end(std::function<InterruptedRun()> end) override;

 private:
  const Console& console_;
  std::optional<Progress> progress_;  ///< of the simulation
};

/// The outputs that a run's scenario asks for, with progress on the terminal.
class RunPictures : public PictureSink {
 public:
  explicit RunPictures(const Console& console) : console_(console) {}

  void draw_segmentation(const SimulationInput& scene, const std::string& dir) override;
  void begin(const SimulationInput& scene, const std::string& dir) override { outputs_.emplace(scene, dir); }
  void snapshots_written(std::int64_t frame) override { outputs_->snapshots_written(frame); }
  [[nodiscard]] const FillBricks& fill_before() const override { return outputs_->fill_before(); }
  void end(const SimulationInput& scene, const std::string& dir) override;
  void make(Diagnostics& report) override { outputs_->make(report, console_); }
  [[nodiscard]] std::string render_context() const override { return outputs_->render_context(); }
  void make_report() override { outputs_->make_report(); }

 private:
  const Console& console_;
  std::optional<Outputs> outputs_;
};

}  // namespace reamsim
