// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/contour_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace reamsim {
namespace {

constexpr double kPointSpacing = 0.5;  // of the raster's spacing
constexpr double kSigma_mm = 0.9;      // of the smoothing along a line
constexpr double kSigmasOfLoop = 14;   // a loop is at least this many sigmas long

/// Marching squares over a raster with a border of low values. Each side of a square that a line crosses has a key; the
/// line enters the next square there, with the greater values on its left.
class Squares {
 public:
  Squares(const RasterField& field, double value) : field_(field), value_(value) {
    for (int j = -1; j < field.raster.ny; ++j) {
      for (int i = -1; i < field.raster.nx; ++i) add_square(i, j);
    }
  }

  /// The closed lines, as points on the sides of squares.
  [[nodiscard]] std::vector<std::vector<Vec2>> loops() {
    std::vector<std::vector<Vec2>> out;
    for (const std::size_t first : order_) {
      if (!next_.contains(first)) continue;
      std::vector<Vec2>& loop = out.emplace_back();
      for (auto at = next_.find(first); at != next_.end(); at = next_.find(loop_end_)) {
        loop.push_back(at->second.from);
        loop_end_ = at->second.to;
        next_.erase(at);
      }
    }
    return out;
  }

 private:
  struct Step {
    Vec2 from;
    std::size_t to = 0;
  };
  struct Crossing {
    std::size_t key;
    Vec2 place;
    bool outward;  ///< from a greater value to a lower one, counter-clockwise around the square
  };

  [[nodiscard]] double value_at(int i, int j) const {
    return field_.raster.contains(i, j) ? field_.values[field_.raster.index(i, j)] : border_;
  }
  [[nodiscard]] std::size_t key(int i, int j, int axis) const {
    return 2 * (static_cast<std::size_t>(i + 1) +
                static_cast<std::size_t>(j + 1) * static_cast<std::size_t>(field_.raster.nx + 2)) +
           static_cast<std::size_t>(axis);
  }

  void add_square(int i, int j) {
    const std::array<Vec3i, 4> corners{Vec3i(i, j, 0), Vec3i(i + 1, j, 0), Vec3i(i + 1, j + 1, 0), Vec3i(i, j + 1, 0)};
    const std::array<std::size_t, 4> keys{key(i, j, 0), key(i + 1, j, 1), key(i, j + 1, 0), key(i, j, 1)};
    std::vector<Crossing> crossings;
    double sum = 0;
    for (std::size_t side = 0; side < 4; ++side) {
      const Vec3i &a = corners[side], &b = corners[(side + 1) % 4];
      const double from = value_at(a.x(), a.y()), to = value_at(b.x(), b.y());
      sum += from;
      if ((from > value_) == (to > value_)) continue;
      const double t = (value_ - from) / (to - from);
      const Vec2 place = (1 - t) * field_.place_mm(a.x(), a.y()) + t * field_.place_mm(b.x(), b.y());
      crossings.push_back({keys[side], place, from > value_});
    }
    // Two lines through a square part at its middle.
    const bool joined = crossings.size() == 4 && sum > 4 * value_;
    for (std::size_t n = 0; n < crossings.size(); ++n) {
      if (!crossings[n].outward) continue;
      const std::size_t end = joined ? n + 1 : n + crossings.size() - 1;
      next_[crossings[n].key] = {crossings[n].place, crossings[end % crossings.size()].key};
      order_.push_back(crossings[n].key);
    }
  }

  const RasterField& field_;
  double value_;
  double border_ = std::min(-1.0, value_ - 1);
  std::unordered_map<std::size_t, Step> next_;
  std::vector<std::size_t> order_;  ///< of the squares, so that the result does not depend on the map's order
  std::size_t loop_end_ = 0;
};

double length_of(const std::vector<Vec2>& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) sum += (loop[(i + 1) % loop.size()] - loop[i]).norm();
  return sum;
}

/// The loop with evenly spaced points.
std::vector<Vec2> resampled(const std::vector<Vec2>& loop, std::size_t count) {
  const double step = length_of(loop) / static_cast<double>(count);
  std::vector<Vec2> out;
  double passed = 0;  // length up to loop[i]
  for (std::size_t i = 0; i < loop.size() && out.size() < count; ++i) {
    const Vec2 &from = loop[i], &to = loop[(i + 1) % loop.size()];
    const double length = (to - from).norm();
    while (out.size() < count && step * static_cast<double>(out.size()) <= passed + length) {
      const double t = length > 0 ? (step * static_cast<double>(out.size()) - passed) / length : 0;
      out.push_back((1 - t) * from + t * to);
    }
    passed += length;
  }
  while (out.size() < count) out.push_back(loop.front());
  return out;
}

/// The Gaussian mean along the loop.
std::vector<Vec2> mean_along(const std::vector<Vec2>& loop, double sigma_points) {
  const auto count = static_cast<std::ptrdiff_t>(loop.size());
  const auto reach = std::min(static_cast<std::ptrdiff_t>(std::ceil(3 * sigma_points)), (count - 1) / 2);
  std::vector<double> weights;
  double total = 0;
  for (std::ptrdiff_t n = -reach; n <= reach; ++n) {
    const double off = static_cast<double>(n) / sigma_points;
    weights.push_back(std::exp(-0.5 * off * off));
    total += weights.back();
  }
  std::vector<Vec2> out(loop.size(), Vec2::Zero());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    for (std::ptrdiff_t n = -reach; n <= reach; ++n) {
      out[static_cast<std::size_t>(i)] += weights[static_cast<std::size_t>(n + reach)] / total *
                                          loop[static_cast<std::size_t>((i + n + count) % count)];
    }
  }
  return out;
}

/// Smooths a loop twice, the second time what the first removed, so that a round line keeps its radius.
std::vector<Vec2> smoothed(const std::vector<Vec2>& loop, double spacing_mm) {
  const double length_mm = length_of(loop);
  const auto count = std::max<std::size_t>(12, static_cast<std::size_t>(length_mm / (kPointSpacing * spacing_mm)));
  std::vector<Vec2> points = resampled(loop, count);
  const double sigma_mm = std::min(std::max(kSigma_mm, 2 * spacing_mm), length_mm / kSigmasOfLoop);
  const double sigma_points = std::max(0.3, sigma_mm * static_cast<double>(count) / length_mm);
  const std::vector<Vec2> once = mean_along(points, sigma_points);
  for (std::size_t i = 0; i < count; ++i) points[i] -= once[i];
  const std::vector<Vec2> rest = mean_along(points, sigma_points);
  for (std::size_t i = 0; i < count; ++i) points[i] = once[i] + rest[i];
  return points;
}

}  // namespace

double ContourLine::length_mm() const {
  return length_of(points_mm);
}

std::vector<ContourLine> contour_lines(const RasterField& field, double value) {
  std::vector<ContourLine> out;
  for (const std::vector<Vec2>& loop : Squares(field, value).loops()) {
    if (loop.size() < 3 || length_of(loop) <= 0) continue;
    out.push_back({value, smoothed(loop, field.spacing_mm)});
  }
  return out;
}

std::vector<ContourLine> depth_contours(const RasterField& signed_depth_mm, const Scale& scale) {
  std::vector<ContourLine> out;
  for (int tick = 1; tick < scale.ticks(); ++tick) {
    for (ContourLine& line : contour_lines(signed_depth_mm, tick * scale.step)) {
      if (line.length_mm() >= kShortestContour_mm) out.push_back(std::move(line));
    }
  }
  return out;
}

}  // namespace reamsim
