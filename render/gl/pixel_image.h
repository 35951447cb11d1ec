// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace reamsim {

/// A rectangle of a picture in pixels, y down; empty if width is 0.
struct Box {
  double x = 0, y = 0, width = 0, height = 0;
};

/// A picture: premultiplied BGRA (Cairo's ARGB32), top row first.
struct PixelImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint32_t> pixels;

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) + static_cast<std::size_t>(x);
  }
  /// Whether each row has one colour, as a picture of the background alone.
  [[nodiscard]] bool has_plain_rows() const;
  /// Composites `part` over this picture with its upper left corner at (x, y), both at least 0, clipped.
  void paste(const PixelImage& part, int x, int y);
};

/// A picture of one colour, 0xRRGGBB.
PixelImage plain_image(int width_px, int height_px, std::uint32_t rgb);

/// The picture reduced by `factor` along each axis: each pixel is the mean of a square.
PixelImage downsampled(PixelImage image, int factor);

/// The picture with smoothed edges, cheaper than multisampling (T. Lottes, "FXAA", NVIDIA white paper, 2009): blends
/// each pixel at a brightness step with its neighbour across it; others stay identical. Transparency is white.
PixelImage antialiased(const PixelImage& image);

/// Writes a PNG: RGB if all is opaque, else RGBA; `software`, if any, near the file's beginning. Throws RunError.
void write_png(const std::string& path, const PixelImage& image, const std::string& software = "");

}  // namespace reamsim
