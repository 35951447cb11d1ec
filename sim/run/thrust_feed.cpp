// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>

#include "sim/run/feed.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

namespace {

class ThrustFeed : public Feed {
 public:
  ThrustFeed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report)
      : scene_(scene),
        plan_(*scene.motion.push),
        stepper_(stepper),
        report_(report),
        frame_s_(scene.motion.frame_s()),
        pictures_(scene.scenario.render, plan_),
        loss_mm_(smallest_advance_mm(scene.bone.voxmap->grid.voxel_mm)) {}

  void start() override {
    const ToolPose first = plan_.pose(0, 0);
    stepper_.start({.frame = 0, .before = first, .pose = first, .duration_s = frame_s_},
                   PushResult{.thrust_n = plan_.thrust_n(0)});
  }
  void resume(const SimulationState& from) override { state_ = from.feed; }

  [[nodiscard]] bool has_ended(std::int64_t frame) const override {
    const PushSettings& push = plan_.settings();
    if (frame >= plan_.last_frame()) return true;
    if (push.until == PushEnd::depth) return has_reached_depth();
    return push.until == PushEnd::stall && has_stalled();
  }

  void add(std::int64_t frame) override {
    const ThrustBalance forces = balance(frame);
    const FeedRate feed = balanced_feed(
        forces, [&](double feed_mm_s) { return bone_force(frame, feed_mm_s); }, state_.bone_n_s_mm);
    const double hand_n = add_thrust_energies(forces, feed, frame_s_, state_);
    const PushResult row{.feed_mm_s = feed.mm_s,
                         .velocity_mm_s = feed.end_mm_s,
                         .thrust_n = forces.thrust_n,
                         .hand_force_n = hand_n,
                         .hand_power_w = 1e-3 * hand_n * feed.mm_s};
    stepper_.add(motion(frame, feed.mm_s * frame_s_, frame_s_), nullptr, row);
    before_mm_ = state_.travel_mm;
    state_.travel_mm += feed.mm_s * frame_s_;
    state_.velocity_mm_s = feed.end_mm_s;
    state_.bone_n_s_mm = feed.bone_n_s_mm;
    state_.still_frames = feed.mm_s < kStill_mm_s && forces.thrust_n > 0 ? state_.still_frames + 1 : 0;
  }
  /// The next feed rate depends on the bone that this one leaves.
  [[nodiscard]] bool ends_batch(std::int64_t) const override { return true; }
  void take(const FrameResult& row) override { state_.drill_mj += 1e3 * row.push->drill_power_w * frame_s_; }

  [[nodiscard]] bool has_picture(std::int64_t frame) const override {
    return has_ended(frame) || pictures_.due(frame, before_mm_, state_.travel_mm);
  }
  [[nodiscard]] std::int64_t last_frame() const override { return plan_.last_frame(); }

  void warn_at_end() override {
    const PushSettings& push = plan_.settings();
    const bool ended_late = stepper_.state().frame >= plan_.last_frame() && push.until != PushEnd::time;
    const bool reached = push.until == PushEnd::depth ? has_reached_depth() : has_stalled();
    if (!ended_late || reached) return;
    report_.warn("motion.push ended after time_s without " +
                 std::string(push.until == PushEnd::depth ? "reaching depth_mm" : "a stall") +
                 (has_stalled() ? ": the bone holds the thrust" : ""));
  }
  [[nodiscard]] SimulationState state() const override { return {stepper_.state(), state_}; }

 private:
  /// Frames with a picture, of which the number is not known before.
  class Pictures {
   public:
    Pictures(const RenderSettings& render, const PushPlan& plan) : render_(render), plan_(plan) {
      if (plan.settings().until == PushEnd::time) frames_ = picture_frames(render, plan.last_frame(), {});
    }
    /// Without a number of frames in the settings, pictures are at equal depths, or at equal times where a time ends
    /// the push.
    [[nodiscard]] bool due(std::int64_t frame, double before_mm, double after_mm) const {
      if (render_.every_frames > 0) return frame % render_.every_frames == 0;
      if (!frames_.empty()) return std::ranges::binary_search(frames_, frame);
      return level(after_mm) > level(before_mm);
    }

   private:
    [[nodiscard]] double level(double travel_mm) const {
      constexpr double kStills = 10, kFilm = 150;
      const bool film = render_.enabled && render_.film != FilmFormat::none;
      const double depth_mm = travel_mm - plan_.settings().approach_mm;
      return std::clamp(std::floor((film ? kFilm : kStills) * depth_mm / plan_.settings().depth_mm), 0.0,
                        film ? kFilm : kStills);
    }

    const RenderSettings& render_;
    const PushPlan& plan_;
    std::vector<std::int64_t> frames_;
  };

  [[nodiscard]] bool has_stalled() const { return static_cast<double>(state_.still_frames) * frame_s_ >= kStall_s; }
  [[nodiscard]] bool has_reached_depth() const { return state_.travel_mm >= plan_.last_travel_mm() - 1e-9; }

  /// The motion over a time at a constant feed, from where the tool is at the start of the frame.
  [[nodiscard]] FrameMotion motion(std::int64_t frame, double advance_mm, double duration_s) const {
    const double begin_s = static_cast<double>(frame - 1) * frame_s_;
    return {.frame = frame,
            .before = plan_.pose(state_.travel_mm, begin_s),
            .pose = plan_.pose(state_.travel_mm + advance_mm, begin_s + duration_s),
            .duration_s = duration_s,
            .time_s = begin_s + duration_s};
  }

  static double axial_n(const SubstepSums& sums) { return static_cast<double>(sums.force[2]) / RS_FORCE_SCALE; }

  /// Mean force of the bone along the tool's axis at a feed.
  double bone_force(std::int64_t frame, double feed_mm_s) {
    const double advance_mm = feed_mm_s * frame_s_, first_mm = kFirstLosses * loss_mm_,
                 second_mm = kSecondLosses * loss_mm_;
    if (advance_mm >= second_mm) return axial_n(stepper_.evaluate({motion(frame, advance_mm, frame_s_)})[0]);
    const auto sums = stepper_.evaluate(
        {motion(frame, first_mm, first_mm / feed_mm_s), motion(frame, second_mm, second_mm / feed_mm_s)});
    return (kSecondLosses * axial_n(sums[1]) - kFirstLosses * axial_n(sums[0])) / (kSecondLosses - kFirstLosses);
  }

  [[nodiscard]] ThrustBalance balance(std::int64_t frame) {
    const PushSettings& push = plan_.settings();
    const bool edges = scene_.scenario.cutting.edge_force.has_value();
    return {.thrust_n = plan_.thrust_n((static_cast<double>(frame) - 0.5) * frame_s_),
            .max_feed_mm_s = push.max_feed_mm_s,
            .damping_n_s_mm = push.damping_n_s_mm,
            .inertia_n_s_mm = 1e-3 * push.mass_kg / frame_s_,
            .velocity_mm_s = push.mass_kg > 0 ? state_.velocity_mm_s : 0,
            .standing_n = edges ? axial_n(stepper_.evaluate({motion(frame, 0, frame_s_)})[0]) : 0};
  }

  const SimulationInput& scene_;
  const PushPlan& plan_;
  FrameStepper& stepper_;
  Diagnostics& report_;
  double frame_s_;
  Pictures pictures_;
  double loss_mm_;        ///< advance of a smallest loss
  double before_mm_ = 0;  ///< travel at the start of the last frame
  FeedState state_;
};

}  // namespace

std::unique_ptr<Feed> thrust_feed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report) {
  return std::make_unique<ThrustFeed>(scene, stepper, report);
}

}  // namespace reamsim
