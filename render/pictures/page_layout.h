// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <utility>

#include "render/gl/camera.h"
#include "render/gl/pixel_image.h"

namespace reamsim {

/// Smaller pictures have no labels, because these would be illegible.
constexpr int kMinLabelled_px = 200;

/// Pixels of a picture per pixel of one 1080 high and at least 1440 wide: the unit of text and lines.
double picture_unit(int width_px, int height_px);

/// The two parts of a picture: the view of the bone, and a column of labels on its right, so that none covers the bone.
struct PageLayout {
  int width_px, height_px;  ///< of the page
  int view_width_px;        ///< of the view, which is as high as the page
  double unit;              ///< picture_unit() of the page

  [[nodiscard]] bool labelled() const { return view_width_px < width_px; }
  /// The part of the column that has labels.
  [[nodiscard]] Box labels() const;
  /// Upper edge of the values, below the title's first line.
  [[nodiscard]] double values_y() const;
  /// The colour bar, without numbers, of the first (0) or second (1) legend.
  [[nodiscard]] Box legend_bar(int index) const;
  /// Centre of the arrows of directions.
  [[nodiscard]] Vec2 directions_px() const;
  /// The scale bar and its length in mm: a round number that fits into the column and this fraction of the view.
  [[nodiscard]] std::pair<Box, double> scale_bar(const Camera& camera, double fraction = 0.25) const;
};

/// Small pages are all view.
PageLayout page_layout(int width_px, int height_px);

/// The largest of 1, 2, 5 × 10ⁿ that is not above `value` (> 0).
double round_down(double value);
/// The smallest of 1, 2, 5 × 10ⁿ that is not below `value` (> 0).
double round_up(double value);

/// Ticks of a legend or axis at 0, step, 2·step … max.
struct Scale {
  double max = 1;
  double step = 1;

  [[nodiscard]] int ticks() const;
  /// The label of a tick, with the decimals that the step needs.
  [[nodiscard]] std::string label(int tick) const;
};

/// A scale with four to eight steps that ends at `max` or just above it; 0…1 when `max` is not positive.
Scale scale_up_to(double max);
/// A scale that ends exactly at `max` (> 0); its last step may be shorter.
Scale scale_exactly(double max);

}  // namespace reamsim
