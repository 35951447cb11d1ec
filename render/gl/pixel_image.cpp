// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/pixel_image.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace reamsim {
namespace {

/// Premultiplied `over` composited over premultiplied `under`.
std::uint32_t blended(std::uint32_t over, std::uint32_t under) {
  const std::uint32_t alpha = over >> 24;
  if (alpha == 255) return over;
  std::uint32_t out = 0;
  for (int shift = 0; shift < 32; shift += 8) {
    const std::uint32_t sum = (over >> shift & 255U) + ((under >> shift & 255U) * (255 - alpha) + 127) / 255;
    out |= std::min(sum, 255U) << shift;
  }
  return out;
}

}  // namespace

bool PixelImage::has_plain_rows() const {
  for (int y = 0; y < height_px; ++y) {
    const auto row = pixels.begin() + std::ptrdiff_t{width_px} * y;
    if (std::any_of(row, row + width_px, [&](std::uint32_t pixel) { return pixel != *row; })) return false;
  }
  return true;
}

void PixelImage::paste(const PixelImage& part, int x, int y) {
  const int columns = std::min(part.width_px, width_px - x);
  const int rows = std::min(part.height_px, height_px - y);
  if (columns <= 0) return;
  for (int row = 0; row < rows; ++row) {
    const auto from = part.pixels.begin() + std::ptrdiff_t{part.width_px} * row;
    const auto to = pixels.begin() + std::ptrdiff_t{width_px} * (y + row) + x;
    std::transform(from, from + columns, to, to, blended);
  }
}

PixelImage plain_image(int width_px, int height_px, std::uint32_t rgb) {
  const auto count = static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  return {width_px, height_px, std::vector<std::uint32_t>(count, 0xff000000U | rgb)};
}

PixelImage downsampled(PixelImage image, int factor) {
  if (factor == 1) return image;
  PixelImage out = plain_image(image.width_px / factor, image.height_px / factor, 0);
  const auto count = static_cast<std::uint32_t>(factor * factor);
  for (int y = 0; y < out.height_px; ++y) {
    for (int x = 0; x < out.width_px; ++x) {
      std::array<std::uint32_t, 4> sums{};
      for (int row = y * factor; row < (y + 1) * factor; ++row) {
        const std::uint32_t* pixel = &image.pixels[image.index(x * factor, row)];
        for (int column = 0; column < factor; ++column, ++pixel) {
          for (std::size_t i = 0; i < 4; ++i) sums[i] += *pixel >> (8 * i) & 255U;
        }
      }
      std::uint32_t& mean = out.pixels[out.index(x, y)] = 0;
      for (std::size_t i = 0; i < 4; ++i) mean |= (sums[i] + count / 2) / count << (8 * i);
    }
  }
  return out;
}

}  // namespace reamsim
