// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/thrust_balance.h"

#include <algorithm>
#include <cmath>

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

/// Searches the feed where the excess is 0: by secants from below until the root is bracketed, then by false position
/// (Illinois).
class Search {
 public:
  Search(Point standing, double max_feed) : low_(standing), before_(standing), max_feed_(max_feed) {}

  /// Takes the excess at next(). Returns false where the search has ended.
  bool take(const Point& p, double tolerance) {
    found_ = p;
    if (std::abs(p.excess) <= tolerance) return false;
    if (p.excess < 0) {
      if (p.feed >= max_feed_) return false;
      if (has_high_ && kept_high_) high_.excess /= 2;
      before_ = low_;
      low_ = p;
      kept_high_ = has_high_;
      kept_low_ = false;
    } else {
      if (has_high_ && kept_low_) low_.excess /= 2;
      high_ = p;
      has_high_ = true;
      kept_low_ = true;
      kept_high_ = false;
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
  Point low_, before_, found_, high_;
  bool has_high_ = false;
  double max_feed_;
  bool kept_low_ = false, kept_high_ = false;
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

}  // namespace reamsim
