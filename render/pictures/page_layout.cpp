// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/page_layout.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

namespace reamsim {
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

/// Tolerance for rounding, so that 0.1 · 30 counts as 3.
static constexpr double kScaleTolerance = 1e-9;

double round_down(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value) + kScaleTolerance));
  const double lead = value / decade;
  return decade * (lead >= 5 - kScaleTolerance ? 5 : lead >= 2 - kScaleTolerance ? 2 : 1);
}

double round_up(double value) {
  const double below = round_down(value);
  if (below >= value * (1 - kScaleTolerance)) return below;
  const double decade = std::pow(10.0, std::floor(std::log10(below) + kScaleTolerance));
  const double lead = below / decade;
  return decade * (lead < 1.5 ? 2 : lead < 3 ? 5 : 10);
}

int Scale::ticks() const {
  return static_cast<int>(std::floor(max / step + 1e-6)) + 1;
}

std::string Scale::label(int tick) const {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - kScaleTolerance)), 0, 6);
  return fmt::format("{:.{}f}", tick * step, decimals);
}

Scale scale_up_to(double max) {
  if (!(max > 0) || !std::isfinite(max)) return {1, 0.2};
  const double step = round_up(max / 8);
  return {step * std::ceil(max / step - 1e-6), step};
}

Scale scale_exactly(double max) {
  return {max, round_up(max / 8)};
}

}  // namespace reamsim
