// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>

#include "sim/engine/common/motion_windows.h"
#include "sim/run/feed.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

namespace {

class PrescribedFeed : public PlannedFeed {
 public:
  PrescribedFeed(const SimulationInput& scene, FrameStepper& stepper)
      : PlannedFeed(scene),
        stepper_(stepper),
        windows_([this](std::int64_t frame) { return args_of(frame); }, scene.motion.last_frame(), stepper.tool_box()),
        windowed_(stepper.can_use_windows() && scene.scenario.engine.tuning.windows) {}

  void start() override { stepper_.start(motion_of(scene().motion.first_frame)); }
  void resume(const SimulationState&) override {}
  void add(std::int64_t frame) override { stepper_.add(motion_of(frame), windowed_ ? windows_.of(frame) : nullptr); }
  /// Slow frames make small batches, so that a run stops soon when it is asked to.
  [[nodiscard]] bool ends_batch(std::int64_t frame) const override {
    constexpr double kMostSeconds = 0.2;
    const auto count = static_cast<double>(stepper_.batch_frames());
    return has_ended(frame) || (frame + 1) % scene().scenario.engine.batch_frames == 0 ||
           count * stepper_.frame_wall_s() > kMostSeconds;
  }
  void take(const FrameResult&) override {}
  void warn_at_end() override {}
  [[nodiscard]] SimulationState state() const override { return {stepper_.state()}; }

 private:
  [[nodiscard]] FrameMotion motion_of(std::int64_t frame) const {
    const Motion& motion = scene().motion;
    return {.frame = frame,
            .before = motion.pose_of(std::max(frame - 1, motion.first_frame)),
            .pose = motion.pose_of(frame),
            .duration_s = motion.frame_s(),
            .time_s = static_cast<double>(frame) * motion.frame_s()};
  }

  /// The substep of a frame that has one.
  [[nodiscard]] std::optional<SubstepArgs> args_of(std::int64_t frame) const {
    if (frame <= scene().motion.first_frame) return std::nullopt;
    return stepper_.single_args(motion_of(frame));
  }

  FrameStepper& stepper_;
  MotionWindows windows_;
  bool windowed_;
};

}  // namespace

PlannedFeed::PlannedFeed(const SimulationInput& scene)
    : scene_(scene), pictures_(picture_frames(scene.scenario.render, scene.last_frame(), scene.contact)) {}

bool PlannedFeed::has_picture(std::int64_t frame) const {
  return std::ranges::binary_search(pictures_, frame);
}

std::unique_ptr<Feed> prescribed_feed(const SimulationInput& scene, FrameStepper& stepper) {
  return std::make_unique<PrescribedFeed>(scene, stepper);
}

}  // namespace reamsim
