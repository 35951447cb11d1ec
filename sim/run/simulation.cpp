// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/simulation.h"

#include <algorithm>

#include "sim/base/error.h"
#include "sim/engine/common/motion_windows.h"
#include "sim/engine/make_engine.h"
#include "sim/run/compliant_run.h"
#include "sim/run/end_batch.h"
#include "sim/run/push_run.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

namespace {

/// The run of a pass whose motion is prescribed, in batches of frames.
class PrescribedRun {
 public:
  PrescribedRun(ReamingScene& scene, Engine& engine, FrameSink& sink, Report& report)
      : scene_(scene),
        report_(report),
        stepper_(scene, engine, sink, report),
        windows_([this](std::int64_t frame) { return args_of(frame); }, scene.motion.last_frame(), stepper_.tool_box()),
        windowed_(stepper_.can_use_windows() && scene.scenario.engine.tuning.windows) {}

  /// The main loop. Frames of a batch end with one that has a picture.
  SimulationState run(const RunControl& control) {
    const std::int64_t first = scene_.motion.first_frame, last = scene_.motion.last_frame();
    const std::vector<std::int64_t> pictures =
        picture_frames(scene_.scenario.render, scene_.last_frame(), scene_.contact);
    const auto has_picture = [&](std::int64_t frame) { return std::ranges::binary_search(pictures, frame); };
    const bool had_ended = control.from && control.from->frame == last;
    if (control.from) stepper_.resume(*control.from);
    if (first == 0 && !control.from) stepper_.snapshot(0);  // the bone before the first pose removes any
    if (!control.from || control.from->frame < first) {
      stepper_.start(motion_of(first));
      if (first > 0 && has_picture(first)) stepper_.snapshot(first);
    }
    for (std::int64_t frame = stepper_.state().frame + 1; frame <= last; ++frame) {
      stepper_.add(motion_of(frame), windowed_ ? windows_.of(frame) : nullptr);
      const bool picture = has_picture(frame);
      if (!picture && frame != last && !is_batch(frame)) continue;
      stepper_.finish_batch();
      if (picture) stepper_.snapshot(frame);
      control.progress(frame, scene_.last_frame());
      end_batch(stepper_, control, [&] { return SimulationState{stepper_.state()}; });
    }
    if (!had_ended && !stepper_.state().touched && !control.warned_of_no_contact) {
      report_.warn(stepper_.name_of_pass() +
                   "the tool never touches the bone: check motion and, if it is used, the glenoid frame");
    }
    stepper_.read_fill();
    return {stepper_.state()};
  }

 private:
  [[nodiscard]] FrameMotion motion_of(std::int64_t frame) const {
    const Motion& motion = scene_.motion;
    return {.frame = frame,
            .before = motion.pose_of(std::max(frame - 1, motion.first_frame)),
            .pose = motion.pose_of(frame),
            .duration_s = motion.frame_s(),
            .time_s = static_cast<double>(frame) * motion.frame_s()};
  }

  /// The substep of a frame that has one.
  [[nodiscard]] std::optional<SubstepArgs> args_of(std::int64_t frame) const {
    if (frame <= scene_.motion.first_frame) return std::nullopt;
    return stepper_.single_args(motion_of(frame));
  }

  /// Whether the pending frames, up to this one, are a batch. Slow frames make small ones, so that a run stops soon
  /// when it is asked to. Results do not depend on batches.
  [[nodiscard]] bool is_batch(std::int64_t frame) const {
    constexpr double kMostSeconds = 0.2;
    const auto count = static_cast<double>(stepper_.batch_frames());
    return (frame + 1) % scene_.scenario.engine.batch_frames == 0 || count * stepper_.frame_wall_s() > kMostSeconds;
  }

  ReamingScene& scene_;
  Report& report_;
  FrameStepper stepper_;
  MotionWindows windows_;
  bool windowed_;
};

}  // namespace

std::unique_ptr<Engine> load_engine(const ReamingScene& scene, EngineDevices& devices) {
  try {
    return make_engine_on(devices, scene.scenario, scene.bone, scene.tool);
  } catch (const InputError& error) {
    throw scene.scenario.keys.located(error);
  }
}

std::unique_ptr<Engine> load_engine(const ReamingScene& scene) {
  EngineDevices devices;
  return load_engine(scene, devices);
}

SimulationState simulate(ReamingScene& scene, Engine& engine, FrameSink& sink, const RunControl& control,
                         Report& report) {
  if (scene.motion.push) return run_push(scene, engine, sink, control, report);
  if (scene.scenario.motion.compliance) return run_compliant(scene, engine, sink, control, report);
  return PrescribedRun(scene, engine, sink, report).run(control);
}

RunCost estimate_cost(const ReamingScene& scene) {
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
