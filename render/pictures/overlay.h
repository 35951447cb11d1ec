// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/camera.h"
#include "render/surface/bone_surface.h"
#include "sim/scenario/choices.h"

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

/// The largest of 1, 2, 5 × 10ⁿ that is not above `value` (> 0), and the smallest that is not below it.
double round_down(double value);
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

/// A colour bar with numbers.
struct Legend {
  std::string title;
  std::string unit;
  ColorMap colors;
  Scale scale;
};

/// A force in B. The length of `direction` is its fraction of the run's greatest force.
struct ForceArrow {
  Vec3 from_mm;
  Vec3 direction;
  std::string text;
};

/// A closed contour line as a camera sees it.
struct SeenContour {
  std::string text;    ///< the number of its tick in the legend
  bool light = false;  ///< drawn light, because the colours of its depth are dark
  std::vector<Vec2> points_px;
  std::vector<bool> visible;  ///< per point: not hidden by bone, nor cut away
};

/// Text and brightness of the contour of a value; without points.
SeenContour contour_style(double value, const Scale& scale);

/// Where the number of a contour is drawn: where the line is visible, farthest from other lines and numbers, if there
/// is such a place. `unit`: pixels per pixel of a picture 1080 high.
struct ContourNumber {
  std::size_t contour = 0;
  Eigen::AlignedBox2d box_px;
};
std::vector<ContourNumber> place_contour_numbers(const std::vector<SeenContour>& contours, const Camera& camera,
                                                 double unit);

struct Labels {
  std::string title;
  std::vector<std::pair<std::string, std::string>> values;  ///< name and number with unit
  std::vector<Legend> legends;                              ///< at most two
  std::vector<std::pair<std::string, Vec3>> directions;     ///< anatomical directions: name and unit vector in B
  std::vector<Vec3> outline_mm;                             ///< closed dashed line in B; may be empty
  std::optional<ForceArrow> force;
  std::vector<SeenContour> contours;  ///< lines of the picture that get their numbers
  double scale_bar_fraction = 0.25;   ///< of the view's width, at most
};

/// The page of a view: the view with its marks, and the column of all other labels beside it. `view` has the size of
/// the layout's view, `camera` that of the view or of one of several pictures in it. Throws RunError.
PixelImage annotated_picture(PixelImage view, const PageLayout& layout, const Camera& camera, const Labels& labels,
                             Background background);
/// An empty page: the colour of the column of labels, or nothing on a transparent background.
PixelImage blank_page(int width_px, int height_px, Background background);

/// Draws the marks of places in a view of the camera's size: outlines, force, numbers of contours. Throws RunError.
void draw_marks(PixelImage& view, const Camera& camera, double unit, const Labels& labels);

/// Draw the lines without their numbers, and the numbers. Throw RunError.
void draw_contours(PixelImage& image, double unit, const std::vector<SeenContour>& contours);
void draw_contour_numbers(PixelImage& image, const Camera& camera, double unit,
                          const std::vector<SeenContour>& contours);

}  // namespace reamsim
