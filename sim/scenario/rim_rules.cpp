// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/linear_algebra.h"
#include "sim/scenario/parse_steps.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

constexpr double kLeastRim_mm = 10;   // a joint face, and not a unit mistaken
constexpr double kMostRim_mm = 100;   // likewise
constexpr double kLeastWidth = 0.05;  // of the length: below, the points lie on a line

/// The points' middle, and their main directions, the least spread first.
struct RimSpread {
  Vec3 middle_mm = Vec3::Zero();
  Mat3 directions;
  Vec3 deviations_mm;
};

RimSpread spread_of(const std::vector<Vec3>& rim_mm) {
  RimSpread out;
  for (const Vec3& p : rim_mm) out.middle_mm += p / static_cast<double>(rim_mm.size());
  Mat3 products = Mat3::Zero();
  for (const Vec3& p : rim_mm) products += (p - out.middle_mm) * (p - out.middle_mm).transpose();
  const SymmetricEigen3 axes = symmetric_eigen(Mat3(products / static_cast<double>(rim_mm.size())));
  out.directions = axes.vectors;
  out.deviations_mm = axes.values.cwiseMax(0).cwiseSqrt();
  return out;
}

/// The first point, counted from 1, to which the way round the middle goes back or stands still; 0 when none does.
std::size_t first_out_of_order(const std::vector<Vec3>& rim_mm, const RimSpread& spread) {
  std::vector<double> steps;
  double turned = 0;
  for (std::size_t i = 0; i < rim_mm.size(); ++i) {
    const Vec3 from = rim_mm[i] - spread.middle_mm;
    const Vec3 to = rim_mm[(i + 1) % rim_mm.size()] - spread.middle_mm;
    const auto angle = [&](const Vec3& p) {
      return std::atan2(p.dot(spread.directions.col(1)), p.dot(spread.directions.col(2)));
    };
    steps.push_back(std::remainder(angle(to) - angle(from), 2 * std::numbers::pi));
    turned += steps.back();
  }
  // Round once, whichever way: then the points that step the other way are the ones out of order.
  const auto forwards = std::count_if(steps.begin(), steps.end(), [](double step) { return step > 0; });
  const double way = 2 * forwards >= static_cast<std::ptrdiff_t>(steps.size()) ? 1 : -1;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (way * steps[i] <= 0) return (i + 1) % rim_mm.size() + 1;
  }
  return std::abs(std::abs(turned) - 2 * std::numbers::pi) < 1e-6 ? 0 : 1;
}

}  // namespace

void check_rim(const std::vector<Vec3>& rim_mm, const KeyLocations& locations) {
  if (rim_mm.empty()) return;
  const std::string key = "bone.glenoid.rim_mm";
  const auto fail = [&](const std::string& found, const std::string& expected) {
    throw InputError(locations.of(key), key, "found " + found, "expected " + expected);
  };
  double length_mm = 0;
  for (const Vec3& a : rim_mm) {
    for (const Vec3& b : rim_mm) length_mm = std::max(length_mm, (a - b).norm());
  }
  if (length_mm < kLeastRim_mm || length_mm > kMostRim_mm) {
    fail("a rim " + number_text(std::round(10 * length_mm) / 10) + " mm long",
         "points in mm around a face of " + number_text(kLeastRim_mm) + " to " + number_text(kMostRim_mm) + " mm");
  }
  const RimSpread spread = spread_of(rim_mm);
  if (spread.deviations_mm[1] < kLeastWidth * spread.deviations_mm[2]) {
    fail("points on one line", "points around the face that span a plane");
  }
  if (const std::size_t point = first_out_of_order(rim_mm, spread); point != 0) {
    fail("point " + std::to_string(point) + " out of order", "the points in order around the face, each once");
  }
}

}  // namespace reamsim
