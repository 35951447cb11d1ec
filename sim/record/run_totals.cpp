// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/run_totals.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "sim/base/file.h"
#include "sim/tool/motion.h"

namespace reamsim {

namespace {

/// Bone holds the tool from this part of the thrust on, and gives way below the other, on average over 10 ms: frames of
/// a slow feed have few voxels each.
constexpr double kHeld = 0.8, kGivesWay = 0.5, kMean_s = 0.01;

/// The tool stands still where its step is below this fraction of the mean step.
constexpr double kStillFraction = 0.01;
/// Frames of a mean, 24 MB: a voxel of travel may take hours.
constexpr std::size_t kMostFrames = 1'000'000;

double travel_mm(const FrameResult& from, const FrameResult& to) {
  return (to.pose.position_mm - from.pose.position_mm).norm();
}

PushEvent event_of(const FrameResult& row, const std::string& name, double value) {
  return {row.frame, row.time_s, row.depth_mm, name, value};
}

}  // namespace

void LayerMean::drop_oldest() {
  axial_force_sum_n_ -= frames_.front().axial_force_n;
  spin_torque_sum_nmm_ -= frames_.front().spin_torque_nmm;
  frames_.pop_front();
}

LayerMean::Means LayerMean::add(const Vec3& position_mm, double axial_force_n, double spin_torque_nmm) {
  const double step = frames_.empty() ? 0 : (position_mm - last_mm_).norm();
  const double path = frames_.empty() ? 0 : frames_.back().path_mm + step;
  if (full_ && step * static_cast<double>(frames_.size()) < kStillFraction * voxel_mm_) drop_oldest();
  if (frames_.size() == kMostFrames) drop_oldest();
  last_mm_ = position_mm;
  frames_.push_back({path, axial_force_n, spin_torque_nmm});
  axial_force_sum_n_ += axial_force_n;
  spin_torque_sum_nmm_ += spin_torque_nmm;
  // A frame is dropped when the travel after its end amounts to a voxel.
  while (frames_.size() > 1 && path - frames_.front().path_mm >= voxel_mm_ * (1 - 1e-9)) {
    drop_oldest();
    full_ = true;
  }
  if (!full_) return {};
  const auto count = static_cast<double>(frames_.size());
  return {axial_force_sum_n_ / count, spin_torque_sum_nmm_ / count, frames_.size()};
}

void PushTotals::add(const FrameResult& row) {
  const PushResult& push = *row.push;
  const double frame_s = last_ ? row.time_s - last_->time_s : 0;
  hand_mj += 1e3 * push.hand_power_w * frame_s;
  spindle_work_mj += 1e3 * push.drill_power_w * frame_s;
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

void PassTotals::add(const FrameResult& row) {
  last_frame = row.frame;
  if (row.in_contact() && first_contact_frame < 0) first_contact_frame = row.frame;
  removed_mm3 += row.removed_mm3;
  energy_mj += row.energy_mj;
  max_depth_mm = std::max(max_depth_mm, row.depth_mm);
  peak_axial_force_n = std::max(peak_axial_force_n, row.axial_force_n);
  peak_spin_torque_nmm = std::max(peak_spin_torque_nmm, std::abs(row.spin_torque_nmm));
}

void DeflectionTotals::add(const FrameResult& row, bool deepest) {
  const Vec3& mm = *row.deflection_mm;
  if (mm.norm() > peak_mm) {
    peak_mm = mm.norm();
    peak_time_s = row.time_s;
  }
  peak_lateral_mm = std::max(peak_lateral_mm, mm.head<2>().norm());
  if (deepest) at_depth_mm = mm;
  at_end_mm = mm;
}

void RunTotals::add(const FrameResult& row) {
  ++frames;
  if (std::ssize(passes) < row.pass) passes.push_back({.first_frame = row.frame});
  PassTotals& pass = passes.back();
  const bool first_contact = row.in_contact() && pass.first_contact_frame < 0;
  const bool deepest = first_contact || row.depth_mm > pass.max_depth_mm;
  if (deepest) deepest_pose = row.pose;
  pass.add(row);
  if (row.axial_force_n > peak_axial_force_n) peak_advance_mm = (row.pose.position_mm - last_position_mm_).norm();
  last_position_mm_ = row.pose.position_mm;
  PassTotals::add(row);
  simulated_s = row.time_s;
  floor_energy_mj += row.floor_energy_mj;
  balance = row.balance;
  peak_force_n = std::max(peak_force_n, row.force_n.norm());
  peak_torque_nmm = std::max(peak_torque_nmm, row.torque_nmm.norm());
  const auto layer = layer_.add(row.pose.position_mm, row.axial_force_n, row.spin_torque_nmm);
  peak_layer_axial_force_n = std::max(peak_layer_axial_force_n, layer.axial_force_n);
  peak_layer_spin_torque_nmm = std::max(peak_layer_spin_torque_nmm, std::abs(layer.spin_torque_nmm));
  if (row.push) {
    if (!push) push.emplace();
    push->add(row);
  }
  if (row.deflection_mm) {
    if (!deflection) deflection.emplace();
    deflection->add(row, deepest);
  }
  if (!row.in_contact()) return;
  ++contact_frames;
  last_contact_frame = row.frame;
  sums_.force_n += row.force_n.norm();
  sums_.torque_nmm += row.torque_nmm.norm();
  sums_.axial_force_n += row.axial_force_n;
  sums_.spin_torque_nmm += row.spin_torque_nmm;
  force_squares_ += row.force_n.squaredNorm();
  torque_squares_ += row.torque_nmm.squaredNorm();
}

double RunTotals::root_mean(double squares) const {
  return contact_frames == 0 ? 0 : std::sqrt(squares / static_cast<double>(contact_frames));
}

KeyResults RunTotals::headline(bool means) const {
  return {.means = means,
          .peak_axial_force_n = means ? peak_layer_axial_force_n : peak_axial_force_n,
          .peak_spin_torque_nmm = means ? peak_layer_spin_torque_nmm : peak_spin_torque_nmm,
          .tool_depth_mm = max_depth_mm};
}

RunTotals::Means RunTotals::means() const {
  if (reaming_frames() == 0) return {};
  const auto count = static_cast<double>(reaming_frames());
  return {.force_n = sums_.force_n / count,
          .torque_nmm = sums_.torque_nmm / count,
          .axial_force_n = sums_.axial_force_n / count,
          .spin_torque_nmm = sums_.spin_torque_nmm / count};
}

}  // namespace reamsim
