// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/page_layout.h"

#include <algorithm>
#include <cmath>

#include "render/pictures/scale.h"

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

}  // namespace reamsim
