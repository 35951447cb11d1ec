// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/camera.h"
#include "render/gl/pixel_image.h"
#include "render/pictures/overlay.h"
#include "sim/record/force_log.h"

namespace reamsim {

/// Labels of a run's pictures from its force log. They need the complete log: the greatest force scales the arrows.
class Captions {
 public:
  using Values = std::vector<std::pair<std::string, std::string>>;  ///< name and number with unit

  /// `mean_travel_mm`: the tool's travel over which forces are averaged; 0: single frames. `arrows`: draw force arrows.
  Captions(ForceLog log, double mean_travel_mm, bool arrows);

  /// Values of a picture during the run.
  [[nodiscard]] Values at(const ForceRow& row) const;
  /// Values of a picture of the final state.
  [[nodiscard]] Values after(double deepest_mm) const;
  /// The bone's force on the tool, at the tool's tip; none if negligible.
  [[nodiscard]] std::optional<ForceArrow> arrow(const ForceRow& row) const;

  /// The log with means.
  [[nodiscard]] const ForceLog& log() const { return log_; }
  /// Key results of the run.
  [[nodiscard]] KeyResults headline() const { return key_results_of(log_, !mean_.empty()); }
  /// Prefix of the names of forces: "mean " or empty.
  [[nodiscard]] const std::string& mean() const { return mean_; }

 private:
  ForceLog log_;
  std::string mean_;
  bool arrows_;
  double max_force_n_ = 0;
};

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
