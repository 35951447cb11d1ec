#include "render/gl/pixel_image.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace reamsim {

namespace {

/// Premultiplied `over` before premultiplied `under`.
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

PixelImage averaged(PixelImage image, int times) {
  if (times == 1) return image;
  PixelImage out = plain_image(image.width_px / times, image.height_px / times, 0);
  const auto count = static_cast<std::uint32_t>(times * times);
  for (int y = 0; y < out.height_px; ++y) {
    for (int x = 0; x < out.width_px; ++x) {
      std::array<std::uint32_t, 4> sums{};
      for (int row = y * times; row < (y + 1) * times; ++row) {
        const auto from = image.pixels.begin() + std::ptrdiff_t{image.width_px} * row + std::ptrdiff_t{x} * times;
        for (auto pixel = from; pixel != from + times; ++pixel) {
          for (std::size_t i = 0; i < 4; ++i) sums[i] += *pixel >> (8 * i) & 255U;
        }
      }
      std::uint32_t mean = 0;
      for (std::size_t i = 0; i < 4; ++i) mean |= (sums[i] + count / 2) / count << (8 * i);
      out.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(out.width_px) + static_cast<std::size_t>(x)] =
          mean;
    }
  }
  return out;
}

}  // namespace reamsim
