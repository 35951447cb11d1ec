// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Not Cairo, whose PNG compression is slow: it took a fifth of the time of a run.

#include "render/gl/camera.h"

#include <png.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <new>

#include "sim/base/error.h"
#include "sim/base/parallel.h"

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

/// The picture with straight (not premultiplied) colours, as in PNG.
PixelImage unpremultiplied(PixelImage image) {
  for (std::uint32_t& pixel : image.pixels) {
    const std::uint32_t premultiplied = pixel, alpha = pixel >> 24;
    pixel = alpha << 24;
    for (int shift = 0; alpha > 0 && shift < 24; shift += 8) {
      pixel |= std::min((255 * (premultiplied >> shift & 255U) + alpha / 2) / alpha, 255U) << shift;
    }
  }
  return image;
}

/// Compresses straight colours; false on failure. libpng leaves it by longjmp(), so no local variable may need a
/// destructor. Paeth prediction with run lengths takes a quarter of the time of zlib's default, for a tenth more bytes.
bool compress(std::FILE* file, const PixelImage& image, bool opaque, std::string software) {
  const auto fail = [](png_structp png, png_const_charp) { png_longjmp(png, 1); };
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, [](png_structp, png_const_charp) {});
  if (png == nullptr) return false;
  png_infop info = png_create_info_struct(png);
  // NOLINTNEXTLINE(cert-err52-cpp): libpng reports errors in no other way to a caller in C++
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_init_io(png, file);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_PAETH);
  constexpr int kRunLengthsOnly = 3;  // Z_RLE of zlib
  png_set_compression_strategy(png, kRunLengthsOnly);
  const auto width = static_cast<png_uint_32>(image.width_px), height = static_cast<png_uint_32>(image.height_px);
  png_set_IHDR(png, info, width, height, 8, opaque ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGBA, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  char key[] = "Software";  // no std::string, whose destructor the jump would leave out
  png_text text{};
  text.compression = PNG_TEXT_COMPRESSION_NONE;
  text.key = key;
  text.text = software.data();
  text.text_length = software.size();
  if (!software.empty()) png_set_text(png, info, &text, 1);
  png_write_info(png, info);
  png_set_bgr(png);
  if (opaque) png_set_filler(png, 0, PNG_FILLER_AFTER);
  const auto* pixels = reinterpret_cast<png_const_bytep>(image.pixels.data());
  for (png_uint_32 y = 0; y < height; ++y) png_write_row(png, pixels + std::size_t{4} * width * y);
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

bool PixelImage::has_plain_rows() const {
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (i % static_cast<std::size_t>(width_px) != 0 && pixels[i] != pixels[i - 1]) return false;
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

void write_png(const std::string& path, const PixelImage& image, const std::string& software) {
  errno = 0;
  const bool opaque = std::ranges::all_of(image.pixels, [](std::uint32_t pixel) { return pixel >> 24 == 255; });
  const PixelImage straight = opaque ? PixelImage() : unpremultiplied(image);
  std::FILE* file = std::fopen(path.c_str(), "wb");
  const bool written = file != nullptr && compress(file, opaque ? image : straight, opaque, software);
  const bool closed = file != nullptr && std::fclose(file) == 0;
  if (written && closed) return;
  if (errno == ENOMEM) throw std::bad_alloc();
  throw RunError(path + ": cannot be written (" + (errno != 0 ? std::strerror(errno) : "no PNG can hold it") +
                 "); is the disk full or the folder read-only?");
}

namespace {

// Brightness is from 0 to 255.
constexpr float kMinStep = 10;            // smaller steps are invisible
constexpr float kMinStepFraction = 0.1F;  // of the brighter side; smaller steps are invisible
constexpr int kMaxSearch_px = 16;         // along an edge, to either side
constexpr float kSoftening = 0.75F;       // of isolated pixels
constexpr std::size_t kGrain_rows = 16;

/// The brightness of each pixel of a picture over white.
class Brightness {
 public:
  explicit Brightness(const PixelImage& image)
      : width_(image.width_px), height_(image.height_px), values_(image.pixels.size()) {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const std::uint32_t p = image.pixels[i];
      values_[i] = 0.299F * channel(p, 16) + 0.587F * channel(p, 8) + 0.114F * channel(p, 0) + 255 - channel(p, 24);
    }
  }

  /// Clamped to the edge outside the picture.
  [[nodiscard]] float at(int x, int y) const {
    return values_[static_cast<std::size_t>(std::clamp(y, 0, height_ - 1)) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(std::clamp(x, 0, width_ - 1))];
  }

 private:
  static float channel(std::uint32_t pixel, int shift) { return static_cast<float>(pixel >> shift & 255U); }

  int width_, height_;
  std::vector<float> values_;
};

/// A pixel with its eight neighbours, [row][column].
using Block = std::array<std::array<float, 3>, 3>;

Block block_at(const Brightness& brightness, int x, int y) {
  Block out{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) out[row][column] = brightness.at(x + column - 1, y + row - 1);
  }
  return out;
}

/// The contrast of a pixel and its four nearest neighbours; 0 where it is invisible.
float visible_step(const Block& b) {
  const auto [least, most] = std::minmax({b[1][1], b[0][1], b[2][1], b[1][0], b[1][2]});
  return most - least < std::max(kMinStep, kMinStepFraction * most) ? 0 : most - least;
}

/// Does the edge through the pixel run along its row rather than along its column?
bool runs_along_row(const Block& b) {
  float across_rows = 0, across_columns = 0;
  for (int i = 0; i < 3; ++i) {
    const float weight = i == 1 ? 2 : 1;
    across_rows += weight * std::abs(b[0][i] + b[2][i] - 2 * b[1][i]);
    across_columns += weight * std::abs(b[i][0] + b[i][2] - 2 * b[i][1]);
  }
  return across_rows >= across_columns;
}

/// The blend fraction of an isolated pixel with its surroundings.
float softening(const Block& b, float step) {
  const float nearest = b[0][1] + b[2][1] + b[1][0] + b[1][2];
  const float corners = b[0][0] + b[0][2] + b[2][0] + b[2][2];
  const float away = std::min(1.0F, std::abs((2 * nearest + corners) / 12 - b[1][1]) / step);
  const float smooth = away * away * (3 - 2 * away);
  return smooth * smooth * kSoftening;
}

/// The edge between a pixel and a neighbour.
struct Edge {
  int across_x, across_y;  ///< from the pixel to its neighbour on the other side
  float mean, step;        ///< brightness: mean and difference of the two
};

Edge edge_at(const Block& b) {
  const bool along_row = runs_along_row(b);
  const float before = along_row ? b[0][1] : b[1][0], after = along_row ? b[2][1] : b[1][2];
  const bool is_before = std::abs(before - b[1][1]) >= std::abs(after - b[1][1]);
  const float other = is_before ? before : after;
  const int sign = is_before ? -1 : 1;
  return {along_row ? 0 : sign, along_row ? sign : 0, (other + b[1][1]) / 2, std::abs(other - b[1][1])};
}

/// The end of an edge to one side.
struct End {
  int distance_px;
  float difference;  ///< of the mean brightness from that at the start
};

End follow(const Brightness& brightness, const Edge& edge, int x, int y, int sign) {
  End end{0, 0};
  while (end.distance_px < kMaxSearch_px) {
    ++end.distance_px;
    (edge.across_x == 0 ? x : y) += sign;
    const float mean = (brightness.at(x, y) + brightness.at(x + edge.across_x, y + edge.across_y)) / 2;
    end.difference = mean - edge.mean;
    if (std::abs(end.difference) >= edge.step / 4) break;
  }
  return end;
}

/// The fraction of the pixel beyond the line that the staircase of the edge approximates.
float fraction_beyond(const Brightness& brightness, const Edge& edge, int x, int y) {
  const End back = follow(brightness, edge, x, y, -1);
  const End ahead = follow(brightness, edge, x, y, 1);
  const End& nearer = back.distance_px < ahead.distance_px ? back : ahead;
  const bool darker = brightness.at(x, y) < edge.mean;
  // At this end the line passes on the other side of the edge.
  if ((nearer.difference < 0) == darker) return 0;
  return 0.5F - static_cast<float>(nearer.distance_px) / static_cast<float>(back.distance_px + ahead.distance_px);
}

std::uint32_t mixed(std::uint32_t pixel, std::uint32_t other, float fraction) {
  const auto weight = static_cast<std::uint32_t>(256 * fraction);
  std::uint32_t out = 0;
  for (int shift = 0; shift < 32; shift += 8) {
    const std::uint32_t sum = (pixel >> shift & 255U) * (256 - weight) + (other >> shift & 255U) * weight;
    out |= (sum + 128) / 256 << shift;
  }
  return out;
}

}  // namespace

PixelImage antialiased(const PixelImage& image) {
  const Brightness brightness(image);
  PixelImage out = image;
  parallel_items(static_cast<std::size_t>(image.height_px), kGrain_rows, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < image.width_px; ++x) {
      const Block block = block_at(brightness, x, y);
      const float step = visible_step(block);
      if (step == 0) continue;
      const Edge edge = edge_at(block);
      const float fraction = std::max(fraction_beyond(brightness, edge, x, y), softening(block, step));
      const int other_x = std::clamp(x + edge.across_x, 0, image.width_px - 1);
      const int other_y = std::clamp(y + edge.across_y, 0, image.height_px - 1);
      std::uint32_t& pixel = out.pixels[image.index(x, y)];
      pixel = mixed(pixel, image.pixels[image.index(other_x, other_y)], fraction);
    }
  });
  return out;
}

}  // namespace reamsim
