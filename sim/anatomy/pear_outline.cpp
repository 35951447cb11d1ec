// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/pear_outline.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/geometry.h"
#include "sim/base/statistics.h"
#include "sim/bone/implicit.h"

namespace reamsim {

namespace {

constexpr std::size_t kLeastPoints = 12;
constexpr double kLeastRatio = 0.5, kMostRatio = 0.95;
constexpr double kSlimmest = 2.02;  // height over the sum of radii at which both circles are one, and a margin

using Parameters = Vec6;

Parameters parameters_of(const PearOutline& o) {
  Parameters out;
  out << o.center_mm, o.axis_rad, o.height_mm, o.radius_mm, o.upper_ratio;
  return out;
}

PearOutline outline_of(const Parameters& p) {
  PearOutline out{
      .center_mm = p.head<2>(), .axis_rad = p[2], .height_mm = p[3], .radius_mm = p[4], .upper_ratio = p[5]};
  out.radius_mm = std::max(out.radius_mm, 1.0);
  out.upper_ratio = std::clamp(out.upper_ratio, kLeastRatio, kMostRatio);
  out.height_mm = std::max(out.height_mm, kSlimmest * out.radius_mm);
  return out;
}

std::vector<double> distances_of(const PearOutline& outline, const std::vector<Vec2>& points) {
  std::vector<double> out;
  for (const Vec2& p : points) out.push_back(outline.distance_mm(p));
  return out;
}

/// Tukey's biweight for residuals of the scale of the points.
std::vector<double> weights_of(const std::vector<double>& residuals) {
  constexpr double kSigmaPerMad = 1.4826, kTukey = 4.685, kLeastScale_mm = 0.2;
  std::vector<double> sizes;
  for (const double r : residuals) sizes.push_back(std::abs(r));
  const double reach = kTukey * std::max(kSigmaPerMad * quantile(sizes, 0.5), kLeastScale_mm);
  std::vector<double> out;
  for (const double r : residuals) {
    const double u = 1 - r * r / (reach * reach);
    out.push_back(u > 0 ? u * u : 0);
  }
  return out;
}

double weighted_squares(const std::vector<double>& residuals, const std::vector<double>& weights) {
  double out = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) out += weights[i] * residuals[i] * residuals[i];
  return out;
}

/// A damped Gauss–Newton step with fixed weights; returns whether the outline is better.
bool improve(PearOutline& outline, const std::vector<Vec2>& points, const std::vector<double>& weights,
             double& damping) {
  const Parameters at = parameters_of(outline);
  const std::vector<double> here = distances_of(outline, points);
  Eigen::MatrixXd slopes(points.size(), 6);
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-4;
    Parameters moved = at;
    moved[k] += k == 5 && at[5] > kMostRatio - kStep ? -kStep : kStep;
    const std::vector<double> there = distances_of(outline_of(moved), points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      slopes(static_cast<Eigen::Index>(i), k) = (there[i] - here[i]) / (moved[k] - at[k]);
    }
  }
  const auto count = static_cast<Eigen::Index>(points.size());
  const Eigen::Map<const Eigen::VectorXd> w(weights.data(), count), r(here.data(), count);
  const Mat6 products = slopes.transpose() * w.asDiagonal() * slopes;
  const Parameters right = slopes.transpose() * w.asDiagonal() * r;
  Mat6 damped = products;
  damped.diagonal() += damping * (products.diagonal() + Parameters::Constant(1e-6));
  const PearOutline next = outline_of(at - solve_ldlt(damped, right));
  const bool better = weighted_squares(distances_of(next, points), weights) < weighted_squares(here, weights);
  if (better) outline = next;
  damping = better ? damping / 5 : damping * 5;
  return better;
}

/// The points' mean and main directions as a first outline, with the smaller circle on one side or the other.
PearOutline first_outline(const std::vector<Vec2>& points, bool reversed) {
  Vec2 mean = Vec2::Zero();
  for (const Vec2& p : points) mean += p / static_cast<double>(points.size());
  Mat2 spread = Mat2::Zero();
  for (const Vec2& p : points) spread += (p - mean) * (p - mean).transpose();
  const SymmetricEigen2 axes = symmetric_eigen(Mat2(spread / static_cast<double>(points.size())));
  const Vec2 along = axes.vectors.col(1);
  // The variance of points around an ellipse is half of each squared semi-axis.
  const Vec2 half = (2 * axes.values.cwiseMax(1e-6)).cwiseSqrt();
  PearOutline out{.center_mm = mean,
                  .axis_rad = std::atan2(along.y(), along.x()) + (reversed ? std::numbers::pi : 0.0),
                  .height_mm = 2 * half.y(),
                  .radius_mm = half.x(),
                  .upper_ratio = 0.75};
  return outline_of(parameters_of(out));
}

}  // namespace

double PearOutline::distance_mm(const Vec2& point_mm) const {
  const Vec2 from = point_mm - center_mm;
  const double along = from.dot(axis()), across = from.x() * axis().y() - from.y() * axis().x();
  return implicit::pear(across, along, radius_mm - height_mm / 2, radius_mm, height_mm / 2 - upper_ratio * radius_mm,
                        upper_ratio * radius_mm);
}

std::optional<OutlineFit> fit_pear(const std::vector<Vec2>& rim_mm) {
  if (rim_mm.size() < kLeastPoints) return std::nullopt;
  constexpr int kRounds = 8, kSteps = 6;
  std::optional<OutlineFit> best;
  for (const bool reversed : {false, true}) {
    PearOutline outline = first_outline(rim_mm, reversed);
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<double> weights = weights_of(distances_of(outline, rim_mm));
      double damping = 1e-3;
      for (int step = 0; step < kSteps; ++step) improve(outline, rim_mm, weights, damping);
    }
    OutlineFit found{.outline = outline, .inlier_fraction = 0, .rms_mm = 0};
    for (const double r : distances_of(outline, rim_mm)) {
      if (std::abs(r) > kRimInlier_mm) continue;
      found.inlier_fraction += 1;
      found.rms_mm += r * r;
    }
    found.rms_mm = std::sqrt(found.rms_mm / std::max(1.0, found.inlier_fraction));
    found.inlier_fraction /= static_cast<double>(rim_mm.size());
    const auto cost = [](const OutlineFit& f) { return f.rms_mm - 2 * f.inlier_fraction; };
    if (!best || cost(found) < cost(*best)) best = found;
  }
  return best;
}

}  // namespace reamsim
