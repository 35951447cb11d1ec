// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/push_totals.h"

#include <fmt/core.h>
#include <algorithm>
#include <iterator>

#include "sim/base/file.h"
#include "sim/tool/push_plan.h"

namespace reamsim {

namespace {

/// Bone holds the tool from this part of the thrust on, and gives way below the other, on average over 10 ms: frames of
/// a slow feed have few voxels each.
constexpr double kHeld = 0.8, kGivesWay = 0.5, kMean_s = 0.01;

double travel_mm(const FrameResult& from, const FrameResult& to) {
  return (to.pose.position_mm - from.pose.position_mm).norm();
}

PushEvent event_of(const FrameResult& row, const std::string& name, double value) {
  return {row.frame, row.time_s, row.depth_mm, name, value};
}

}  // namespace

void PushTotals::add(const FrameResult& row) {
  const PushResult& push = *row.push;
  const double frame_s = last_ ? row.time_s - last_->time_s : 0;
  hand_mj += 1e3 * push.hand_power_w * frame_s;
  drill_mj += 1e3 * push.drill_power_w * frame_s;
  peak_hand_power_w = std::max(peak_hand_power_w, push.hand_power_w);
  peak_drill_power_w = std::max(peak_drill_power_w, push.drill_power_w);
  if (row.in_contact()) peak_feed_mm_s = std::max(peak_feed_mm_s, push.feed_mm_s);
  still_s_ = last_ && push.feed_mm_s < kStill_mm_s && push.thrust_n > 0 ? still_s_ + frame_s : 0;
  add_events(row);
  last_ = row;
}

void PushTotals::add_events(const FrameResult& row) {
  const PushResult& push = *row.push;
  for (Breakthrough& b : breakthroughs_) {
    if (!b.open) continue;
    b.event.value += travel_mm(*last_, row);
    b.open = row.time_s - b.event.time_s < kOvershoot_s - 1e-9;
  }
  if (!last_) return;  // the bone in the first pose is removed without force
  if (row.in_contact() && !first_contact_) {
    first_contact_ = *last_;
    events_.push_back(event_of(row, "contact", push.feed_mm_s));
  }
  if (!first_contact_) return;
  if (still_s_ >= kStall_s - 1e-9 && !stalled_) events_.push_back(event_of(row, "stall", push.thrust_n));
  stalled_ = still_s_ >= kStall_s - 1e-9;
  mean_force_n_ += (row.axial_force_n - mean_force_n_) * std::min(1.0, (row.time_s - last_->time_s) / kMean_s);
  if (mean_force_n_ >= kHeld * push.thrust_n && push.thrust_n > 0) held_ = true;
  if (held_ && mean_force_n_ < kGivesWay * push.thrust_n) {
    held_ = false;
    breakthroughs_.push_back({event_of(row, "breakthrough", 0)});
  }
}

std::vector<PushEvent> PushTotals::events() const {
  std::vector<PushEvent> out = events_;
  for (const Breakthrough& b : breakthroughs_) out.push_back(b.event);
  std::ranges::stable_sort(out, {}, &PushEvent::frame);
  if (last_) out.push_back(event_of(*last_, "end", last_->push->feed_mm_s));
  return out;
}

double PushTotals::mean_feed_mm_s() const {
  if (!first_contact_ || last_->time_s <= first_contact_->time_s) return 0;
  return travel_mm(*first_contact_, *last_) / (last_->time_s - first_contact_->time_s);
}

std::optional<double> PushTotals::overshoot_mm() const {
  if (breakthroughs_.empty()) return std::nullopt;
  const auto largest =
      std::ranges::max_element(breakthroughs_, {}, [](const Breakthrough& b) { return b.event.value; });
  return largest->event.value;
}

void write_push_events(const std::string& dir, const PushTotals& push) {
  std::string text = "frame,time_s,depth_mm,event,value\n";
  for (const PushEvent& e : push.events()) {
    text += fmt::format("{},{:.6g},{:.6g},{},{:.6g}\n", e.frame, e.time_s, e.depth_mm, e.event, e.value);
  }
  write_file(dir + "/events.csv", text);
}

}  // namespace reamsim
