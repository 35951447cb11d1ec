// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "sim/record/results.h"

namespace reamsim {

/// What happens in a push (docs/columns.md, events.csv).
struct PushEvent {
  std::int64_t frame = 0;
  double time_s = 0;
  double depth_mm = 0;
  std::string event;  ///< contact, stall, breakthrough, end
  double value = 0;   ///< see docs/columns.md
};

/// Sums, extremes and events of a push, row by row.
class PushTotals {
 public:
  void add(const FrameResult& row);

  /// The time after a breakthrough over which its overshoot counts, s.
  static constexpr double kOvershoot_s = 0.2;

  /// The events so far; the last one is the end.
  [[nodiscard]] std::vector<PushEvent> events() const;
  double hand_mj = 0;
  double drill_mj = 0;
  double peak_feed_mm_s = 0;  ///< in contact
  double peak_hand_power_w = 0;
  double peak_drill_power_w = 0;
  /// Mean feed from first contact on; 0 without contact.
  [[nodiscard]] double mean_feed_mm_s() const;
  /// Travel within kOvershoot_s after a breakthrough, the largest; nullopt without one.
  [[nodiscard]] std::optional<double> overshoot_mm() const;

 private:
  struct Breakthrough {
    PushEvent event;
    bool open = true;  ///< its overshoot may grow
  };

  void add_events(const FrameResult& row);

  std::vector<PushEvent> events_;  ///< besides breakthroughs and the end
  std::vector<Breakthrough> breakthroughs_;
  std::optional<FrameResult> first_contact_, last_;
  double still_s_ = 0;
  bool stalled_ = false;  ///< since it last moved
  bool held_ = false;     ///< by bone, since contact or the last breakthrough
  double mean_force_n_ = 0;
};

/// Writes DIR/events.csv. Throws RunError.
void write_push_events(const std::string& dir, const PushTotals& push);

}  // namespace reamsim
