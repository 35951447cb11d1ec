// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/captions.h"

#include <algorithm>

#include "sim/base/text.h"

namespace reamsim {
namespace {

/// Least fraction of the run's greatest force that is drawn as an arrow.
constexpr double kMinArrowFraction = 0.01;

}  // namespace

Captions::Captions(ForceLog log, double mean_travel_mm, bool arrows)
    : log_(std::move(log)), mean_(mean_travel_mm > 0 ? "mean " : ""), arrows_(arrows) {
  add_layer_means(log_, mean_travel_mm);
  for (const ForceRow& row : log_.rows) {
    max_force_n_ = std::max(max_force_n_, row.layer_force_n.norm());
  }
}

Captions::Values Captions::at(const ForceRow& row) const {
  const bool several = log_.rows.back().pass > 1;
  Values out{{several ? "pass " + std::to_string(row.pass) + ", time" : "time", fixed_text(row.time_s, 3) + " s"},
             {"tool depth", depth_text(row.depth_mm)},
             {mean_ + "axial force", fixed_text(row.layer_axial_force_n, 1) + " N"},
             {mean_ + "spin torque", fixed_text(row.layer_spin_torque_nmm, 0) + " N·mm"},
             {"removed", fixed_text(row.removed_mm3, 1) + " mm³"}};
  if (row.push) out.insert(out.begin() + 2, {"feed rate", fixed_text(row.push->feed_mm_s, 2) + " mm/s"});
  return out;
}

Captions::Values Captions::after(double deepest_mm) const {
  const KeyResults run = headline();
  return {{KeyResults::kDepthName, run.depth_text() + " mm"},
          {run.force_name(), run.force_text() + " N"},
          {run.torque_name(), run.torque_text() + " N·mm"},
          {"removed", fixed_text(log_.rows.back().removed_mm3, 1) + " mm³"},
          {"greatest reamed depth", fixed_text(deepest_mm, 2) + " mm"}};
}

std::optional<ForceArrow> Captions::arrow(const ForceRow& row) const {
  const double force_n = row.layer_force_n.norm();
  if (!arrows_ || force_n == 0 || force_n < kMinArrowFraction * max_force_n_) return std::nullopt;
  // The resultant; a mean has only its axial part.
  const std::string name = mean_.empty() ? "resultant " : mean_ + "axial force ";
  return ForceArrow{row.pose.position_mm, row.layer_force_n / max_force_n_, name + fixed_text(force_n, 1) + " N"};
}

}  // namespace reamsim
