#include "render/gl/pixel_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sim/base/parallel.h"

namespace reamsim {
namespace {

// Brightness is from 0 to 255.
constexpr float kLeastStep = 10;                // smaller steps cannot be seen
constexpr float kMinStepFraction = 0.1F;  // nor can these beside something bright
constexpr int kMostSteps_px = 16;               // how far an edge is followed either way
constexpr float kSoftening = 0.75F;             // of single pixels
constexpr std::size_t kGrain_rows = 16;

/// How bright each pixel of a picture is on white paper.
class Brightness {
 public:
  explicit Brightness(const PixelImage& image)
      : width_(image.width_px), height_(image.height_px), values_(image.pixels.size()) {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const std::uint32_t p = image.pixels[i];
      values_[i] = 0.299F * channel(p, 16) + 0.587F * channel(p, 8) + 0.114F * channel(p, 0) + 255 - channel(p, 24);
    }
  }

  /// Beyond the picture's edge it goes on as at the edge.
  [[nodiscard]] float at(int x, int y) const {
    return values_[static_cast<std::size_t>(std::clamp(y, 0, height_ - 1)) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(std::clamp(x, 0, width_ - 1))];
  }

 private:
  static float channel(std::uint32_t pixel, int shift) { return static_cast<float>(pixel >> shift & 255U); }

  int width_, height_;
  std::vector<float> values_;
};

/// A pixel with the eight around it, [row][column].
using Block = std::array<std::array<float, 3>, 3>;

Block block_at(const Brightness& brightness, int x, int y) {
  Block out{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) out[row][column] = brightness.at(x + column - 1, y + row - 1);
  }
  return out;
}

/// Brightest less darkest of the pixel and its four nearest; 0 where that is too little to be seen.
float visible_step(const Block& b) {
  const auto [least, most] = std::minmax({b[1][1], b[0][1], b[2][1], b[1][0], b[1][2]});
  return most - least < std::max(kLeastStep, kMinStepFraction * most) ? 0 : most - least;
}

/// Whether the edge through the pixel runs rather along its row than along its column.
bool runs_along_row(const Block& b) {
  float across_rows = 0;
  float across_columns = 0;
  for (int i = 0; i < 3; ++i) {
    const float weight = i == 1 ? 2 : 1;
    across_rows += weight * std::abs(b[0][i] + b[2][i] - 2 * b[1][i]);
    across_columns += weight * std::abs(b[i][0] + b[i][2] - 2 * b[i][1]);
  }
  return across_rows >= across_columns;
}

/// The share of a single pixel that its surroundings should have.
float softening(const Block& b, float step) {
  const float nearest = b[0][1] + b[2][1] + b[1][0] + b[1][2];
  const float corners = b[0][0] + b[0][2] + b[2][0] + b[2][2];
  const float away = std::min(1.0F, std::abs((2 * nearest + corners) / 12 - b[1][1]) / step);
  const float smooth = away * away * (3 - 2 * away);
  return smooth * smooth * kSoftening;
}

/// The edge between a pixel and a neighbour, followed along the edge.
struct Edge {
  int across_x, across_y;  ///< from the pixel to its neighbour on the other side
  float mean, step;        ///< between the two and from one to the other
};

Edge edge_at(const Block& b) {
  const bool along_row = runs_along_row(b);
  const float before = along_row ? b[0][1] : b[1][0];
  const float after = along_row ? b[2][1] : b[1][2];
  const bool is_before = std::abs(before - b[1][1]) >= std::abs(after - b[1][1]);
  const float other = is_before ? before : after;
  const int sign = is_before ? -1 : 1;
  return {along_row ? 0 : sign, along_row ? sign : 0, (other + b[1][1]) / 2, std::abs(other - b[1][1])};
}

/// Where an edge ends to one side.
struct End {
  int distance_px;
  float difference;  ///< of the mean there to that at the start
};

End follow(const Brightness& brightness, const Edge& edge, int x, int y, int sign) {
  const int along_x = edge.across_x == 0 ? sign : 0;
  const int along_y = edge.across_x == 0 ? 0 : sign;
  End end{0, 0};
  while (end.distance_px < kMostSteps_px) {
    ++end.distance_px;
    const int px = x + end.distance_px * along_x;
    const int py = y + end.distance_px * along_y;
    const float mean = (brightness.at(px, py) + brightness.at(px + edge.across_x, py + edge.across_y)) / 2;
    end.difference = mean - edge.mean;
    if (std::abs(end.difference) >= edge.step / 4) break;
  }
  return end;
}

/// The share of the pixel that lies beyond the line which the edge's steps stand for.
float fraction_beyond(const Brightness& brightness, const Edge& edge, int x, int y) {
  const End back = follow(brightness, edge, x, y, -1);
  const End on = follow(brightness, edge, x, y, 1);
  const End& nearer = back.distance_px < on.distance_px ? back : on;
  const bool darker = brightness.at(x, y) < edge.mean;
  // At this end the line runs through the other side of the edge.
  if ((nearer.difference < 0) == darker) return 0;
  return 0.5F - static_cast<float>(nearer.distance_px) / static_cast<float>(back.distance_px + on.distance_px);
}

std::uint32_t mixed(std::uint32_t pixel, std::uint32_t other, float share) {
  const auto weight = static_cast<std::uint32_t>(256 * share);
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
  const auto index = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width_px) + static_cast<std::size_t>(x);
  };
  parallel_ranges(static_cast<std::size_t>(image.height_px), kGrain_rows, [&](std::size_t begin, std::size_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < image.width_px; ++x) {
        const Block block = block_at(brightness, x, y);
        const float step = visible_step(block);
        if (step == 0) continue;
        const Edge edge = edge_at(block);
        const float share = std::max(fraction_beyond(brightness, edge, x, y), softening(block, step));
        const int other_x = std::clamp(x + edge.across_x, 0, image.width_px - 1);
        const int other_y = std::clamp(y + edge.across_y, 0, image.height_px - 1);
        out.pixels[index(x, y)] = mixed(image.pixels[index(x, y)], image.pixels[index(other_x, other_y)], share);
      }
    }
  });
  return out;
}

}  // namespace reamsim
