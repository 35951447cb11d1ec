#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "render/camera.h"
#include "render/color_map.h"
#include "render/scale.h"

namespace reamsim {

/// A colour bar with numbers.
struct Legend {
  std::string title;
  std::string unit;
  ColorMap colors;
  Scale scale;
};

/// What is written over a picture.
struct Labels {
  std::string title;
  std::vector<std::pair<std::string, std::string>> values;  ///< name and number with unit, one per line
  std::vector<Legend> legends;
  std::vector<std::pair<std::string, Vec3>> directions;  ///< anatomical directions: name and unit vector in B
  std::vector<std::vector<Vec3>> outlines_mm;            ///< closed dashed lines in B
};

/// Where each element stands; empty (width 0) when the picture has no room for it. Pixels, y down.
struct Box {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
};

/// Pictures smaller than this on a side carry no labels: they could not be read.
constexpr int kLeastLabelled_px = 200;

/// The colour bar of the `index`-th of `count` legends, without its numbers. Empty when the picture is too small.
Box legend_box(const Camera& camera, int index, int count);
/// The scale bar, and its length in mm.
std::pair<Box, double> scale_bar(const Camera& camera);

/// Draws the labels over a picture (BGRA, top row first, width and height of the camera). Throws RunError.
void draw_labels(std::vector<std::uint32_t>& pixels, const Camera& camera, const Labels& labels);

/// Writes the picture as a PNG. Throws RunError when it cannot be written.
void write_png(const std::string& path, std::vector<std::uint32_t>& pixels, int width_px, int height_px);

}  // namespace reamsim
