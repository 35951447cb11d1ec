// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/camera.h"
#include "render/gl/pixel_image.h"
#include "render/pictures/page_layout.h"
#include "render/surface/color_map.h"
#include "sim/scenario/choices.h"

namespace reamsim {

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
  Box box;
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
PixelImage labelled_page(PixelImage view, const PageLayout& layout, const Camera& camera, const Labels& labels,
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
