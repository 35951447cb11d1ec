#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/camera.h"
#include "render/gl/pixel_image.h"
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

/// A force in B: where it acts, and which way, as long as its share of the run's greatest.
struct ForceArrow {
  Vec3 from_mm;
  Vec3 direction;
  std::string text;
};

/// What is written over a picture.
struct Labels {
  std::string title;
  std::vector<std::pair<std::string, std::string>> values;  ///< name and number with unit, one per line
  std::string widest_value;  ///< room is kept for it, so that the box is as wide in every picture of a run
  std::vector<Legend> legends;
  std::vector<std::pair<std::string, Vec3>> directions;  ///< anatomical directions: name and unit vector in B
  std::vector<std::vector<Vec3>> outlines_mm;            ///< closed dashed lines in B
  std::optional<ForceArrow> force;
  double scale_bar_fraction = 0.20;  ///< how much of the picture's width the scale bar may take
};

/// Pictures smaller than this on a side carry no labels: they could not be read.
constexpr int kMinLabelled_px = 200;

/// The colour bar of the `index`-th of `count` legends, without its numbers. Empty when the picture is too small.
Box legend_box(const Camera& camera, int index, int count);
/// The scale bar, and its length in mm: a round number that takes up to this share of the picture's width.
std::pair<Box, double> scale_bar(const Camera& camera, double share = 0.20);

/// Draws the labels over a picture of the camera's size. Throws RunError.
void draw_labels(PixelImage& image, const Camera& camera, const Labels& labels);
/// Draws nothing but the outlines, on a picture of any size. Throws RunError.
void draw_outlines(PixelImage& image, const Camera& camera, const Labels& labels);
/// Draws nothing but title and values, their box moved right by `left_px`. Throws RunError.
void draw_value_box(PixelImage& image, const Camera& camera, const Labels& labels, double left_px);

}  // namespace reamsim
