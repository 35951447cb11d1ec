// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/simulation.h"

#include "sim/base/error.h"
#include "sim/engine/make_engine.h"
#include "sim/run/feed.h"

namespace reamsim {

namespace {

std::unique_ptr<Feed> make_feed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report) {
  if (scene.motion.push) return thrust_feed(scene, stepper, report);
  if (scene.scenario.motion.compliance) return spring_feed(scene, stepper, report);
  return prescribed_feed(scene, stepper);
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
  stepper.begin_batch();
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

RunCost estimate_cost(const SimulationInput& scene) {
  const double max_step_mm = scene.scenario.engine.max_step_voxels * scene.bone.voxmap->grid.voxel_mm;
  RunCost cost{.frames = scene.last_frame()};
  const auto add = [&](const Tool& tool, const PoseSequence& poses) {
    for (std::size_t k = 1; k < poses.size(); ++k) {
      cost.substeps +=
          count_substeps(poses[k - 1], poses[k], tool, is_moved_by_spin(scene.scenario, tool), max_step_mm);
    }
  };
  add(scene.tool, scene.motion.poses);
  for (const Pass& pass : scene.later_passes) add(pass.tool, pass.motion.poses);
  return cost;
}

}  // namespace reamsim
