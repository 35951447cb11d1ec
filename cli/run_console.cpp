// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/run_console.h"

#include "render/pictures/figures.h"

namespace reamsim {

void RunConsole::say(const std::string& line) {
  progress_.reset();
  console_.say(line);
}

void RunConsole::take(const Diagnostics& report) {
  progress_.reset();
  Diagnostics printed = report;
  console_.print(printed);
}

void RunConsole::progress(std::int64_t done, std::int64_t total) {
  if (!progress_) progress_.emplace(console_, "simulate", "frames");
  if (done > 0) progress_->update(done, total);
}

std::shared_ptr<void> RunConsole::on_forced_end(std::function<InterruptedRun()> end) {
  return std::make_shared<ForcedStop>([end = std::move(end)]() -> StopOutcome {
    const InterruptedRun remains = end();
    return {remains.saved ? kSuspendedStatus : kInterruptedStatus, remains.message};
  });
}

void RunPictures::draw_segmentation(const SimulationInput& scene, const std::string& dir) {
  if (scene.scenario.render.enabled) write_segmentation_picture(dir, *scene.bone.segmentation);
}

void RunPictures::end(const SimulationInput& scene, const std::string& dir) {
  if (outputs_) {
    outputs_->finish_run(scene.bone.fill);
  } else {
    outputs_.emplace(Outputs::of_finished(scene, dir));
  }
}

}  // namespace reamsim
