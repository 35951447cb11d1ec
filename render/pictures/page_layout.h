// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <utility>

#include "render/gl/camera.h"
#include "render/gl/pixel_image.h"

namespace reamsim {

/// Smaller pictures have no labels, because these would be illegible.
constexpr int kMinLabelled_px = 200;

/// Pixels of a picture per pixel of one 1080 high and at least 1440 wide: the unit of text and lines.
double picture_unit(int width_px, int height_px);

/// The two parts of a picture: the view of the bone on the left, and a column for title, values, legends, directions
/// and scale bar on the right, so that none of these covers the bone.
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
  /// The scale bar of a view and its length in mm: a round number that fits into the column and is at most this
  /// fraction of the view.
  [[nodiscard]] std::pair<Box, double> scale_bar(const Camera& camera, double fraction = 0.25) const;
};

/// Small pages are all view.
PageLayout page_layout(int width_px, int height_px);

}  // namespace reamsim
