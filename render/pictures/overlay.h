#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/camera.h"
#include "render/gl/pixel_image.h"
#include "render/pictures/contour_labels.h"
#include "render/pictures/scale.h"
#include "render/surface/color_map.h"

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

/// The labels of a picture.
struct Labels {
  std::string title;
  std::vector<std::pair<std::string, std::string>> values;  ///< name and number with unit, one per line
  std::string widest_value;  ///< reserves room, so that the box has one width in all pictures of a run
  std::vector<Legend> legends;
  std::vector<std::pair<std::string, Vec3>> directions;  ///< anatomical directions: name and unit vector in B
  std::vector<std::vector<Vec3>> outlines_mm;            ///< closed dashed lines in B
  std::optional<ForceArrow> force;
  std::vector<SeenContour> contours;  ///< lines of the picture that get their numbers
  double scale_bar_fraction = 0.20;   ///< of the picture's width, at most
};

/// Smaller pictures have no labels, because these would be illegible.
constexpr int kMinLabelled_px = 200;

/// The colour bar, without numbers, of legend `index` of `count`. Empty when the picture is too small.
Box legend_box(const Camera& camera, int index, int count);
/// The scale bar and its length in mm: a round number, at most this fraction of the picture's width.
std::pair<Box, double> scale_bar(const Camera& camera, double fraction = 0.20);

/// Draws the labels over a picture of the camera's size. Throws RunError.
void draw_labels(PixelImage& image, const Camera& camera, const Labels& labels);
/// Draws only the outlines, on a picture of any size. Throws RunError.
void draw_outlines(PixelImage& image, const Camera& camera, const Labels& labels);
/// Draws only title and values, moved right by `left_px`. Throws RunError.
void draw_value_box(PixelImage& image, const Camera& camera, const Labels& labels, double left_px);

}  // namespace reamsim
