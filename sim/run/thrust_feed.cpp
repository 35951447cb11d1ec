// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>

#include "sim/run/balance.h"
#include "sim/run/feed.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

namespace {

constexpr double kForceTolerance = 1e-5;  ///< of the thrust
constexpr double kFeedTolerance = 1e-7;   ///< of the feed: the force jumps there
constexpr int kMostEvaluations = 60;
constexpr int kMostMiddles = 8;
constexpr double kMiddleTolerance = 1e-6;

/// θ of balanced_feed().
double middle_of(double lambda) {
  if (lambda < 1e-3) return 0.5 + lambda / 12;
  return 1 / -std::expm1(-lambda) - 1 / lambda;
}

/// A feed and the force that is missing (< 0) or too much (> 0) there.
struct Point {
  double feed = 0;
  double excess = 0;
};

/// Searches the feed where the excess is 0: by secants from below to a bracket, then by false position (Illinois).
class Search {
 public:
  Search(Point standing, double max_feed) : low_(standing), before_(standing), max_feed_(max_feed) {}

  /// Takes the excess at next(). Returns false where the search has ended.
  bool take(const Point& p, double tolerance) {
    found_ = p;
    if (std::abs(p.excess) <= tolerance) return false;
    if (p.excess < 0) {
      if (p.feed >= max_feed_) return false;
      if (kept_ == Kept::high) high_.excess /= 2;
      before_ = low_;
      low_ = p;
      if (has_high_) kept_ = Kept::high;
    } else {
      if (kept_ == Kept::low) low_.excess /= 2;
      high_ = p;
      has_high_ = true;
      kept_ = Kept::low;
    }
    if (!has_high_ || high_.feed - low_.feed > kFeedTolerance * high_.feed) return true;
    // A jump: the side of contact, where the tool then rests.
    found_ = high_;
    return false;
  }

  [[nodiscard]] double next() const {
    if (!has_high_) {
      const double slope = (low_.excess - before_.excess) / (low_.feed - before_.feed);
      const double feed = slope > 0 ? low_.feed - low_.excess / slope : max_feed_;
      return std::clamp(feed, std::min(1.0001 * low_.feed, max_feed_), max_feed_);
    }
    const double width = high_.feed - low_.feed;
    const double feed = low_.feed - low_.excess * width / (high_.excess - low_.excess);
    return std::clamp(feed, low_.feed + 0.01 * kFeedTolerance * width, high_.feed - 0.01 * kFeedTolerance * width);
  }
  [[nodiscard]] const Point& found() const { return found_; }

 private:
  enum class Kept { none, low, high };  ///< the end of the bracket that the last step has kept

  Point low_, before_, found_, high_;
  bool has_high_ = false;
  double max_feed_;
  Kept kept_ = Kept::none;
};

/// The feed for a given θ.
FeedRate feed_for(const ThrustBalance& b, const BoneForce& bone, double slope, double middle) {
  const double inertia = b.inertia_n_s_mm / middle;
  FeedRate out{.middle = middle};
  const auto excess = [&](double feed, double force) {
    return force + b.damping_n_s_mm * feed + inertia * (feed - b.velocity_mm_s) - b.thrust_n;
  };
  const Point standing{0, excess(0, b.standing_n)};
  if (standing.excess >= 0) {
    out.bone_n = b.standing_n;
    return out;
  }
  const double rate = slope + b.damping_n_s_mm + inertia;
  Search search(standing, b.max_feed_mm_s);
  const double tolerance = kForceTolerance * std::max(b.thrust_n, std::abs(standing.excess));
  double feed = rate > 0 ? std::min(-standing.excess / rate, b.max_feed_mm_s) : b.max_feed_mm_s;
  for (;;) {
    out.bone_n = bone(feed);
    const Point p{feed, excess(feed, out.bone_n)};
    ++out.evaluations;
    if (!search.take(p, tolerance) || out.evaluations == kMostEvaluations) break;
    feed = search.next();
  }
  out.mm_s = search.found().feed;
  if (out.mm_s != feed) out.bone_n = bone(out.mm_s);
  out.limited = out.mm_s >= b.max_feed_mm_s && search.found().excess < -tolerance;
  out.bone_n_s_mm = std::max(0.0, (out.bone_n - b.standing_n) / out.mm_s);
  return out;
}

class ThrustFeed : public Feed {
 public:
  ThrustFeed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report)
      : scene_(scene),
        plan_(*scene.motion.push),
        stepper_(stepper),
        report_(report),
        frame_s_(scene.motion.frame_s()),
        loss_mm_(smallest_advance_mm(scene.bone.voxmap->grid.voxel_mm)) {
    if (plan_.settings().until == PushEnd::time) {
      pictures_ = picture_frames(scene.scenario.render, plan_.last_frame(), {});
    }
  }

  void start() override {
    const ToolPose first = plan_.pose(0, 0);
    stepper_.start({.frame = 0,
                    .before = first,
                    .pose = first,
                    .duration_s = frame_s_,
                    .push = PushResult{.thrust_n = plan_.thrust_n(0)}});
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
    FrameMotion next = motion(frame, feed.mm_s * frame_s_, frame_s_);
    next.push = {.feed_mm_s = feed.mm_s,
                 .velocity_mm_s = feed.end_mm_s,
                 .thrust_n = forces.thrust_n,
                 .hand_force_n = hand_n,
                 .hand_power_w = 1e-3 * hand_n * feed.mm_s};
    stepper_.add(next);
    before_mm_ = state_.travel_mm;
    state_.travel_mm += feed.mm_s * frame_s_;
    state_.velocity_mm_s = feed.end_mm_s;
    state_.bone_n_s_mm = feed.bone_n_s_mm;
    state_.still_frames = feed.mm_s < kStill_mm_s && forces.thrust_n > 0 ? state_.still_frames + 1 : 0;
  }
  void take(const FrameResult& row) override { state_.spindle_work_mj += 1e3 * row.push->drill_power_w * frame_s_; }

  /// Without render.every_frames pictures are at equal depths, or at equal times where a time ends the push.
  [[nodiscard]] bool has_picture(std::int64_t frame) const override {
    const int every = scene_.scenario.render.every_frames;
    if (has_ended(frame)) return true;
    if (every > 0) return frame % every == 0;
    if (!pictures_.empty()) return std::ranges::binary_search(pictures_, frame);
    return level(state_.travel_mm) > level(before_mm_);
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
  /// The number of the picture that is due at a travel.
  [[nodiscard]] double level(double travel_mm) const {
    constexpr double kStills = 7, kFilm = 150;
    const RenderSettings& render = scene_.scenario.render;
    const double most = render.enabled && render.film != FilmFormat::none ? kFilm : kStills;
    const double depth_mm = travel_mm - plan_.settings().approach_mm;
    return std::clamp(std::floor(most * depth_mm / plan_.settings().depth_mm), 0.0, most);
  }

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

  static double axial_n(const SubstepSums& sums) { return force_of(sums).z(); }

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
  std::vector<std::int64_t> pictures_;  ///< frames, where a time ends the push
  double loss_mm_;                      ///< advance of a smallest loss
  double before_mm_ = 0;                ///< travel at the start of the last frame
  FeedState state_;
};

}  // namespace

FeedRate balanced_feed(const ThrustBalance& b, const BoneForce& bone, double slope_n_s_mm) {
  if (b.inertia_n_s_mm <= 0) {
    FeedRate out = feed_for(b, bone, slope_n_s_mm, 1);
    out.end_mm_s = out.mm_s;
    return out;
  }
  const auto middle_for = [&](double slope) { return middle_of((slope + b.damping_n_s_mm) / b.inertia_n_s_mm); };
  double middle = middle_for(slope_n_s_mm);
  FeedRate out;
  int evaluations = 0;
  for (int i = 0; i < kMostMiddles; ++i) {
    out = feed_for(b, bone, slope_n_s_mm, middle);
    evaluations += out.evaluations;
    if (out.mm_s == 0) break;
    slope_n_s_mm = out.bone_n_s_mm;
    const double better = middle_for(slope_n_s_mm);
    if (std::abs(better - middle) < kMiddleTolerance) break;
    middle = better;
  }
  out.evaluations = evaluations;
  const double end = b.velocity_mm_s + (out.mm_s - b.velocity_mm_s) / out.middle;
  out.end_mm_s = out.mm_s == 0 ? 0 : std::clamp(end, 0.0, b.max_feed_mm_s);
  return out;
}

double add_thrust_energies(const ThrustBalance& b, const FeedRate& feed, double frame_s, FeedState& state) {
  const double per_mj = 1e-3;  // of kg·mm²/s²; N·mm are mJ
  const double mass_kg = b.inertia_n_s_mm * frame_s / per_mj, change = feed.end_mm_s - b.velocity_mm_s;
  const double damping_n = b.damping_n_s_mm * feed.mm_s, inertia_n = b.inertia_n_s_mm * change;
  const double hand_n = feed.limited ? feed.bone_n + damping_n + inertia_n : b.thrust_n;
  const double kinetic_mj = 0.5 * per_mj * mass_kg * feed.end_mm_s * feed.end_mm_s;
  state.hand_mj += hand_n * feed.mm_s * frame_s;
  state.damping_mj += damping_n * feed.mm_s * frame_s;
  // M·Δv·v̄ = ΔE + M·(θ − ½)·Δv², and all of E where the tool is stopped.
  const double gained_mj = kinetic_mj - state.kinetic_mj;
  state.lost_mj += feed.mm_s == 0 ? -gained_mj : inertia_n * feed.mm_s * frame_s - gained_mj;
  state.kinetic_mj = kinetic_mj;
  return hand_n;
}

std::unique_ptr<Feed> thrust_feed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report) {
  return std::make_unique<ThrustFeed>(scene, stepper, report);
}

}  // namespace reamsim
