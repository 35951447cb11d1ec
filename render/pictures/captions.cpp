// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/captions.h"

#include <algorithm>
#include <cmath>

#include "render/pictures/overlay.h"
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

namespace {

// Lengths in pixels of a picture 1080 high.
constexpr double kColumn = 388;
constexpr double kPageMargin = 24;
constexpr double kTitleLine = 46;
constexpr double kLegendTop = 524;  // of the colour bar, below its title: six values fit above
constexpr double kLegendMax = 420;
constexpr double kSecondLegend = 0.54;  // of the labels' width
constexpr double kBarWidth = 34;
constexpr double kFoot = 266;  // directions and scale bar
constexpr double kScaleBar = 10;

}  // namespace

double picture_unit(int width_px, int height_px) {
  return std::min(height_px / 1080.0, width_px / 1440.0);
}

PageLayout page_layout(int width_px, int height_px) {
  const double unit = picture_unit(width_px, height_px);
  const bool labelled = std::min(width_px, height_px) >= kMinLabelled_px;
  const int column_px = labelled ? static_cast<int>(std::lround(kColumn * unit)) : 0;
  return {width_px, height_px, width_px - column_px, unit};
}

Box PageLayout::labels() const {
  const double margin = kPageMargin * unit;
  return {view_width_px + margin, margin, width_px - view_width_px - 2 * margin, height_px - 2 * margin};
}

double PageLayout::values_y() const {
  return labels().y + kTitleLine * unit;
}

Box PageLayout::legend_bar(int index) const {
  const Box box = labels();
  const double height = std::min(kLegendMax * unit, height_px - (kLegendTop + kFoot) * unit);
  return {box.x + index * kSecondLegend * box.width, kLegendTop * unit, kBarWidth * unit, height};
}

Vec2 PageLayout::directions_px() const {
  const Box box = labels();
  return {box.x + 0.5 * box.width, height_px - 150 * unit};
}

std::pair<Box, double> PageLayout::scale_bar(const Camera& camera, double fraction) const {
  const Box box = labels();
  const double length_mm = round_down(camera.mm_per_px * std::min(fraction * view_width_px, box.width));
  const double height = kScaleBar * unit;
  return {{box.x, box.y + box.height - height, length_mm / camera.mm_per_px, height}, length_mm};
}

}  // namespace reamsim
