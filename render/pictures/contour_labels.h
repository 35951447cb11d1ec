// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "render/gl/camera.h"
#include "render/gl/pixel_image.h"
#include "render/pictures/page_layout.h"

namespace reamsim {

/// A closed contour line as a camera sees it.
struct SeenContour {
  std::string text;    ///< the number of its tick in the legend
  bool light = false;  ///< drawn light, because the colours of its depth are dark
  std::vector<Vec2> points_px;
  std::vector<bool> visible;  ///< per point: not hidden by bone, nor cut away
};

/// Text and brightness of the contour of a value; without points.
SeenContour contour_style(double value, const Scale& scale);
/// Opacity and width of contour lines, in every picture; the width holds for a picture 1080 high.
constexpr double kContourOpacity = 0.75;
constexpr double kContourWidth_px = 2.2;

/// Where the number of each contour is drawn: where the line is visible, farthest from the other lines and numbers.
/// Contours without such a place have no number.
/// `unit`: pixels per pixel of a picture 1080 high.
struct ContourNumber {
  std::size_t contour = 0;
  Box box;
};
std::vector<ContourNumber> place_contour_numbers(const std::vector<SeenContour>& contours, const Camera& camera,
                                                 double unit);

/// Draws the lines, without numbers. Throws RunError.
void draw_contours(PixelImage& image, double unit, const std::vector<SeenContour>& contours);
/// Draws the numbers. Throws RunError.
void draw_contour_numbers(PixelImage& image, const Camera& camera, double unit,
                          const std::vector<SeenContour>& contours);

}  // namespace reamsim
