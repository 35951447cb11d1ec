// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/simulation.h"

#include <fmt/core.h>

#include <cmath>

#include "sim/engine/common/substep.h"
#include "sim/run/feed.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

namespace {

/// The poses of the motion, in batches of frames.
class PrescribedFeed : public PlannedFeed {
 public:
  PrescribedFeed(const SimulationInput& scene, FrameStepper& stepper)
      : PlannedFeed(scene),
        stepper_(stepper),
        windows_([this](std::int64_t frame) { return args_of(frame); }, scene.motion.last_frame(), stepper.tool_box()),
        windowed_(stepper.can_use_windows() && scene.scenario.engine.tuning.windows) {}

  void start() override { stepper_.start(motion_of(scene().motion.first_frame)); }
  void add(std::int64_t frame) override { stepper_.add(motion_of(frame), windowed_ ? windows_.of(frame) : nullptr); }
  [[nodiscard]] bool ends_batch(std::int64_t frame) const override {
    const int most = scene().scenario.engine.batch_frames;
    return has_ended(frame) || (frame + 1) % most == 0 || stepper_.is_full(most);
  }
  [[nodiscard]] SimulationState state() const override { return {stepper_.state()}; }

 private:
  [[nodiscard]] FrameMotion motion_of(std::int64_t frame) const { return planned_motion(scene().motion, frame); }

  [[nodiscard]] std::optional<SubstepArgs> args_of(std::int64_t frame) const {
    if (frame <= scene().motion.first_frame) return std::nullopt;
    return stepper_.single_args(motion_of(frame));
  }

  FrameStepper& stepper_;
  MotionWindows windows_;
  bool windowed_;
};

std::unique_ptr<Feed> make_feed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report) {
  if (scene.motion.push) return thrust_feed(scene, stepper, report);
  if (scene.scenario.motion.compliance) return spring_feed(scene, stepper, report);
  return std::make_unique<PrescribedFeed>(scene, stepper);
}

/// Continues, or simulates the first pose of the pass. Returns whether the pass has ended before.
bool begin_pass(const SimulationInput& scene, FrameStepper& stepper, Feed& feed, const RunControl& control) {
  const std::int64_t first = scene.motion.first_frame;
  if (control.from) {
    stepper.resume(*control.from);
    feed.resume(*control.from);
    if (control.from->frame >= first) return feed.has_ended(control.from->frame);
  } else if (first == 0) {
    stepper.snapshot(0);  // the bone before the first pose removes any
  }
  feed.start();
  if (first > 0 && feed.has_picture(first)) stepper.snapshot(first);
  return false;
}

/// Saves the state where that is due, and ends the run where that is asked for. Throws Interrupted.
void end_batch(FrameStepper& stepper, const Feed& feed, const RunControl& control) {
  const bool stop = control.stop();
  if (stop || control.save_due()) {
    stepper.read_fill();
    control.save(feed.state());
  }
  if (stop) throw Interrupted();
}

void warn_at_end(FrameStepper& stepper, Feed& feed, const RunControl& control, Diagnostics& report) {
  if (!stepper.state().touched && !control.warned_of_no_contact) {
    report.warn(stepper.name_of_pass() +
                "the tool never touches the bone: check motion and, if it is used, the glenoid frame");
  }
  feed.warn_at_end();
}

/// More than teeth cause that come and go within a voxel of travel.
constexpr double kRagged = 0.15;

std::string two_digits_below(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
  return fmt::format("{:.10g}", std::floor(value / unit) * unit);
}

/// The rounding of losses counts where the tool hardly advances in the frame of the peak force.
void warn_of_rounding(const SimulationInput& scene, const RunTotals& totals, Diagnostics& report) {
  const double enough_mm = kFirstLosses * smallest_advance_mm(scene.bone.voxmap->grid.voxel_mm);
  if (totals.peak_advance_mm == 0 || totals.peak_advance_mm >= enough_mm) return;
  report.warn(fmt::format(
      "the tool advances {:.2g} um in the frame of the peak force, near the smallest loss of a voxel: peaks "
      "of single frames are too large, while volume, energy and means are right; set "
      "motion.frame_rate_hz to {} or less",
      1000 * totals.peak_advance_mm,
      two_digits_below(scene.scenario.motion.frame_rate_hz * totals.peak_advance_mm / enough_mm)));
}

void warn_of_edges(const SimulationInput& scene, const RunTotals& totals, Diagnostics& report) {
  const double over_mean = totals.peak_axial_force_n / totals.peak_layer_axial_force_n - 1;
  if (scene.scenario.tool.spin != ToolSpin::resolved || !(over_mean > kRagged)) return;
  report.warn(
      fmt::format("the peak axial force of a single frame is {:.0f} % above the greatest mean over a voxel of "
                  "travel, {:.1f} N: a resolved edge that lies along the voxels cuts a whole row of them at "
                  "once; take forces.peak_layer_axial_force_n, or a smaller bone.voxel_mm",
                  100 * over_mean, totals.peak_layer_axial_force_n));
}

}  // namespace

std::unique_ptr<Engine> load_engine(const SimulationInput& scene, EngineDevices& devices) {
  try {
    return make_engine_on(devices, scene.scenario, scene.bone, scene.tool);
  } catch (const InputError& error) {
    throw scene.scenario.keys.located(error);
  }
}

std::unique_ptr<Engine> load_engine(const SimulationInput& scene) {
  EngineDevices devices;
  return load_engine(scene, devices);
}

SimulationState simulate(SimulationInput& scene, Engine& engine, FrameSink& sink, const RunControl& control,
                         Diagnostics& report) {
  FrameStepper stepper(scene, engine, sink, report);
  const std::unique_ptr<Feed> feed = make_feed(scene, stepper, report);
  const bool had_ended = begin_pass(scene, stepper, *feed, control);
  for (std::int64_t frame = stepper.state().frame; !feed->has_ended(frame);) {
    feed->add(++frame);  // broad phase, enqueue
    const bool picture = feed->has_picture(frame);
    if (!picture && !feed->ends_batch(frame)) continue;
    stepper.collect();
    stepper.record();
    feed->take(stepper.last());
    if (picture) stepper.snapshot(frame);
    control.progress(frame, feed->last_frame());
    end_batch(stepper, *feed, control);
  }
  if (!had_ended) warn_at_end(stepper, *feed, control, report);
  stepper.read_fill();
  return feed->state();
}

std::int64_t count_all_substeps(const SimulationInput& scene) {
  const double max_step_mm = scene.scenario.engine.max_step_voxels * scene.bone.voxmap->grid.voxel_mm;
  std::int64_t out = 0;
  const auto add = [&](const Tool& tool, const PoseSequence& poses) {
    for (std::size_t k = 1; k < poses.size(); ++k) {
      out += count_substeps(poses[k - 1], poses[k], tool, is_moved_by_spin(scene.scenario, tool), max_step_mm);
    }
  };
  add(scene.tool, scene.motion.poses);
  for (const Pass& pass : scene.later_passes) add(pass.tool, pass.motion.poses);
  return out;
}

void warn_of_peaks(const SimulationInput& scene, const RunTotals& totals, Diagnostics& report) {
  if (scene.scenario.cutting.erosion != ErosionMode::exact) return;
  warn_of_rounding(scene, totals, report);
  warn_of_edges(scene, totals, report);
}

}  // namespace reamsim
