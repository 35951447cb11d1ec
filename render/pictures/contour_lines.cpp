// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/contour_lines.h"

#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "sim/base/parallel.h"
#include "sim/base/statistics.h"

namespace reamsim {
namespace {

constexpr double kWeightSigma_mm = 0.7;  // of the weights in known columns
constexpr double kValueSigma = 0.3;      // of the values: columns across a steep rim hardly count
constexpr double kLeastSigma = 1.6;      // columns
constexpr int kMaxReach = 10;            // columns
constexpr double kOutsideSigma = 1.5;    // columns; of the plane beyond the known ones
constexpr int kOutsideReach = 4;         // columns
constexpr int kMinKnown = 4;             // columns for a plane
constexpr double kRidge = 1e-3;          // of the weight; keeps the fit to few columns defined
constexpr double kLeastMargin = 0.1;     // of the spacing: the least value below zero outside the rim

/// The value of a plane (`degree` 1) or quadratic (2) fitted in a window with these weights, and its known columns.
template <int degree>
std::pair<double, int> fit_in(const RasterField& field, const std::vector<std::uint8_t>& known,
                              const std::vector<double>& weights, std::size_t own) {
  const Raster& raster = field.raster;
  const int reach = static_cast<int>(weights.size()) / 2, i = raster.column(own), j = raster.row(own);
  // Sums of weight·x^a·y^b, and of the same times the value, by [b][a].
  std::array<std::array<double, 2 * degree + 1>, 2 * degree + 1> sums{};
  std::array<std::array<double, degree + 1>, degree + 1> value_sums{};
  int count = 0;
  for (int dj = std::max(-reach, -j); dj <= std::min(reach, raster.ny - 1 - j); ++dj) {
    std::array<double, 2 * degree + 1> row{};
    std::array<double, degree + 1> value_row{};
    for (int di = std::max(-reach, -i); di <= std::min(reach, raster.nx - 1 - i); ++di) {
      const std::size_t n = raster.index(i + di, j + dj);
      if (known[n] == 0) continue;
      // Against the bias of a quadratic that spans a rim and the level face beside it (a bilateral filter).
      const double away = known[own] != 0 ? (field.values[n] - field.values[own]) / kValueSigma : 0;
      const double bilateral = away != 0 ? std::exp(-0.5 * away * away) : 1;
      double term = weights[static_cast<std::size_t>(di + reach)] * bilateral;
      for (std::size_t a = 0; a < row.size(); ++a, term *= static_cast<double>(di) / reach) {
        row[a] += term;
        if (a <= degree) value_row[a] += term * field.values[n];
      }
      ++count;
    }
    double power = weights[static_cast<std::size_t>(dj + reach)];
    for (std::size_t b = 0; b < row.size(); ++b, power *= static_cast<double>(dj) / reach) {
      for (std::size_t a = 0; a < row.size(); ++a) sums[b][a] += power * row[a];
      for (std::size_t a = 0; a <= degree && b <= degree; ++a) value_sums[b][a] += power * value_row[a];
    }
  }
  if (count == 0) return {0, 0};
  constexpr int kTerms = (degree + 1) * (degree + 2) / 2;
  constexpr std::array<std::size_t, 6> kX{0, 1, 0, 2, 1, 0}, kY{0, 0, 1, 0, 1, 2};
  Eigen::Matrix<double, kTerms, kTerms> normal;
  Eigen::Matrix<double, kTerms, 1> right;
  for (int k = 0; k < kTerms; ++k) {
    right(k) = value_sums[kY[k]][kX[k]];
    for (int l = 0; l < kTerms; ++l) normal(k, l) = sums[kY[k] + kY[l]][kX[k] + kX[l]];
  }
  for (int k = 1; k < kTerms; ++k) normal(k, k) += kRidge * normal(0, 0);
  return {solve_ldlt(normal, right)(0), count};
}

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
      std::vector<Vec2> loop;
      for (auto step = next_.extract(first); step; step = next_.extract(step.mapped().to)) {
        loop.push_back(step.mapped().from);
      }
      if (!loop.empty()) out.push_back(std::move(loop));
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
  const std::size_t count = loop.size();
  const std::size_t reach = std::min(static_cast<std::size_t>(std::ceil(3 * sigma_points)), (count - 1) / 2);
  const std::vector<double> weights = gaussian_weights(sigma_points, static_cast<int>(reach));
  std::vector<Vec2> out(count, Vec2::Zero());
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < weights.size(); ++k) out[i] += weights[k] * loop[(i + count + k - reach) % count];
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

double RasterField::at(const Vec2& place_mm) const {
  const Vec2 last(raster.nx - 1, raster.ny - 1);
  const Vec2 index = ((place_mm - corner_mm) / spacing_mm).cwiseMax(Vec2::Zero()).cwiseMin(last);
  const int i = std::min(static_cast<int>(index.x()), std::max(0, raster.nx - 2));
  const int j = std::min(static_cast<int>(index.y()), std::max(0, raster.ny - 2));
  const int next_i = std::min(i + 1, raster.nx - 1), next_j = std::min(j + 1, raster.ny - 1);
  const double x = index.x() - i, y = index.y() - j;
  return (1 - y) * ((1 - x) * values[raster.index(i, j)] + x * values[raster.index(next_i, j)]) +
         y * ((1 - x) * values[raster.index(i, next_j)] + x * values[raster.index(next_i, next_j)]);
}

RasterField local_fit(const RasterField& field, const std::vector<std::uint8_t>& known,
                      const std::vector<std::uint8_t>& wanted) {
  const double sigma = std::max(kLeastSigma, kWeightSigma_mm / field.spacing_mm);
  const auto inside = gaussian(sigma, std::min(kMaxReach, static_cast<int>(std::ceil(2.2 * sigma))));
  const auto outside = gaussian(kOutsideSigma, kOutsideReach);
  RasterField out = field;
  parallel_items(known.size(), [&](std::size_t n) {
    if (!wanted.empty() && wanted[n] == 0) return;
    const auto [value, count] =
        known[n] != 0 ? fit_in<2>(field, known, inside, n) : fit_in<1>(field, known, outside, n);
    out.values[n] = known[n] != 0 || count >= kMinKnown ? value : std::numeric_limits<double>::quiet_NaN();
  });
  return out;
}

RasterField signed_depth(const RasterField& depth_mm, const std::vector<std::uint8_t>& reamed) {
  RasterField out = local_fit(depth_mm, reamed);
  const double margin_mm = kLeastMargin * depth_mm.spacing_mm;
  const double far_mm = kOutsideReach * depth_mm.spacing_mm;
  for (std::size_t n = 0; n < out.values.size(); ++n) {
    double& value = out.values[n];
    // At a wall the plane is still above zero beyond the rim. Mirrored, it passes zero between the two columns.
    value = reamed[n] != 0      ? std::max(value, margin_mm)
            : std::isnan(value) ? -far_mm
                                : -std::clamp(std::abs(value), margin_mm, far_mm);
  }
  return out;
}

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
