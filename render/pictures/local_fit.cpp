// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/local_fit.h"

#include <algorithm>
#include <cmath>

#include "sim/base/gaussian.h"
#include "sim/base/linear_algebra.h"
#include "sim/base/parallel.h"

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

/// Weights of the columns around one.
struct Window {
  Window(double sigma, int reach_columns) : reach(reach_columns), weights(gaussian(sigma, reach_columns)) {}

  int reach;
  std::vector<double> weights;
};

/// The fit's value in the middle of a window, and the number of its known columns. `Terms`: 3 for a plane, 6 for a
/// quadratic.
template <int Terms>
std::pair<double, int> fit_in(const RasterField& field, const std::vector<std::uint8_t>& known, const Window& window,
                              std::size_t own) {
  using Basis = Eigen::Matrix<double, Terms, 1>;
  Eigen::Matrix<double, Terms, Terms> normal = Eigen::Matrix<double, Terms, Terms>::Zero();
  Basis right = Basis::Zero();
  int count = 0;
  const int i = field.raster.column(own), j = field.raster.row(own);
  field.raster.for_each_near(own, window.reach, [&](std::size_t n) {
    if (known[n] == 0) return;
    const int di = field.raster.column(n) - i, dj = field.raster.row(n) - j;
    // Against the bias of a quadratic that spans a rim and the level face beside it (a bilateral filter).
    const double away = known[own] != 0 ? (field.values[n] - field.values[own]) / kValueSigma : 0;
    const double weight = window.weights[static_cast<std::size_t>(di + window.reach)] *
                          window.weights[static_cast<std::size_t>(dj + window.reach)] * std::exp(-0.5 * away * away);
    const double x = static_cast<double>(di) / window.reach, y = static_cast<double>(dj) / window.reach;
    Basis basis;
    if constexpr (Terms == 3) {
      basis << 1, x, y;
    } else {
      basis << 1, x, y, x * x, x * y, y * y;
    }
    normal += weight * basis * basis.transpose();
    right += weight * field.values[n] * basis;
    ++count;
  });
  if (count == 0) return {0, 0};
  for (int k = 1; k < Terms; ++k) normal(k, k) += kRidge * normal(0, 0);
  return {solve_ldlt(normal, right)(0), count};
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
                      std::vector<std::uint8_t>& reached) {
  const double sigma = std::max(kLeastSigma, kWeightSigma_mm / field.spacing_mm);
  const Window inside(sigma, std::min(kMaxReach, static_cast<int>(std::ceil(2.2 * sigma))));
  const Window outside(kOutsideSigma, kOutsideReach);
  RasterField out = field;
  std::vector<std::uint8_t> found(known.size(), 0);
  parallel_items(known.size(), [&](std::size_t n) {
    const auto [value, count] =
        known[n] != 0 ? fit_in<6>(field, known, inside, n) : fit_in<3>(field, known, outside, n);
    if (known[n] == 0 && count < kMinKnown) return;
    out.values[n] = value;
    found[n] = 1;
  });
  reached = std::move(found);
  return out;
}

RasterField signed_depth(const RasterField& depth_mm, const std::vector<std::uint8_t>& reamed) {
  std::vector<std::uint8_t> reached;
  RasterField out = local_fit(depth_mm, reamed, reached);
  const double margin_mm = kLeastMargin * depth_mm.spacing_mm;
  const double far_mm = kOutsideReach * depth_mm.spacing_mm;
  for (std::size_t n = 0; n < out.values.size(); ++n) {
    double& value = out.values[n];
    if (reamed[n] != 0) {
      value = std::max(value, margin_mm);
    } else if (reached[n] != 0) {
      // At a wall the plane is still above zero beyond the rim. Mirrored, it passes zero between the two columns.
      value = -std::clamp(std::abs(value), margin_mm, far_mm);
    } else {
      value = -far_mm;
    }
  }
  return out;
}

}  // namespace reamsim
