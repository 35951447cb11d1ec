#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace reamsim {

/// A part of a picture. Pixels, y down; width 0 is nothing.
struct Box {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
};

/// A picture: BGRA, colours times opacity (as Cairo's ARGB32 has it), top row first.
struct PixelImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint32_t> pixels;

  /// Lays `part` over this picture, which shows where it is transparent, its upper left corner at (x, y), 0 or more.
  /// What does not fit is left out.
  void paste(const PixelImage& part, int x, int y);
};

/// A picture of one colour, 0xRRGGBB.
PixelImage plain_image(int width_px, int height_px, std::uint32_t rgb);

/// The picture 1/`times` as wide and as high: every pixel the mean of a square of them.
PixelImage averaged(PixelImage image, int times);

/// The picture with its jagged edges smoothed, as after multisampling at a small part of the price: where the
/// brightness steps, each pixel takes from its neighbour across the step the share that the edge's line, followed along
/// its steps, would cut off it; single bright or dark pixels are softened (T. Lottes, "FXAA", NVIDIA white paper,
/// 2009). Flat parts and slow shades stay as they are, to the bit. What is transparent counts as white.
PixelImage antialiased(const PixelImage& image);

/// Writes the picture as a PNG: RGB where all of it is opaque, RGBA otherwise. Throws RunError when it cannot be
/// written.
void write_png(const std::string& path, const PixelImage& image);

}  // namespace reamsim
