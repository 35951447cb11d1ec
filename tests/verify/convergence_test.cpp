// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Order and grid convergence index against series whose order and limit are known.
#include "sim/verify/closed_forms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace reamsim::verify {
namespace {

/// Levels of limit·(1 + factor·step^order), steps 1, 1/2, ...
std::vector<Level> series(double limit, double factor, double order, int count) {
  std::vector<Level> out;
  for (int i = 0; i < count; ++i) {
    const double step = std::pow(0.5, i), error = factor * std::pow(step, order);
    out.push_back({step, limit * (1 + error), error, 1});
  }
  return out;
}

TEST(Convergence, OrderOfAPowerIsItsExponent) {
  for (const double order : {0.7, 1.0, 2.0, 3.5}) {
    const auto levels = series(12, -0.01, order, 4);
    EXPECT_NEAR(observed_order(levels).value_or(0), order, 1e-9);
    EXPECT_NEAR(grid_index(levels, 2).order.value_or(0), order, 1e-9);
  }
}

TEST(Convergence, RoundingHasNoOrder) {
  EXPECT_FALSE(observed_order(series(12, 0.1 * kRoundingError, 2, 4)));
  auto levels = series(12, 0.01, 2, 4);
  for (Level& level : levels) level.error.reset();
  EXPECT_FALSE(observed_order(levels));
}

TEST(Convergence, IndexOfThreeLevelsIsTheErrorTimesItsSafety) {
  // Of second order Richardson's extrapolation is the limit, so that the index is 1.25 times the finest error.
  const auto levels = series(12, 0.01, 2, 4);
  const GridIndex index = grid_index(levels, 2);
  EXPECT_DOUBLE_EQ(index.safety_factor, 1.25);
  EXPECT_NEAR(index.fraction, 1.25 * std::abs(12 - levels.back().found) / levels.back().found, 1e-12);
}

TEST(Convergence, OrderAboveTheFormalOneIsNotTrusted) {
  // An order of 4 would make the index small; the formal order bounds it.
  const auto levels = series(12, 0.01, 4, 3);
  const double difference = std::abs(levels[2].found - levels[1].found);
  EXPECT_NEAR(grid_index(levels, 2).fraction, 1.25 * difference / (3 * levels[2].found), 1e-12);
}

TEST(Convergence, LevelsThatDoNotConvergeTakeTheLargerFactor) {
  std::vector<Level> levels = {{1, 10, {}, 1}, {0.5, 12, {}, 1}, {0.25, 11.5, {}, 1}};
  const GridIndex index = grid_index(levels, 2);
  EXPECT_FALSE(index.order);
  EXPECT_DOUBLE_EQ(index.safety_factor, 3);
  EXPECT_NEAR(index.fraction, 3 * 2 / (3 * 11.5), 1e-12) << "the larger of the differences counts";
  levels.erase(levels.begin());
  EXPECT_DOUBLE_EQ(grid_index(levels, 2).safety_factor, 3) << "two levels";
}

TEST(Convergence, NotANumberNeverPasses) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Measure measure :
       {Measure::relative, Measure::absolute, Measure::at_least, Measure::at_most, Measure::reported}) {
    EXPECT_FALSE((Check{"", "", measure, 1, nan, 1e9, ""}.passed()));
  }
}

TEST(Convergence, ToleranceIsTheLargestErrorEitherWay) {
  EXPECT_TRUE((Check{"", "", Measure::relative, 200, 201, 0.0051, ""}.passed()));
  EXPECT_FALSE((Check{"", "", Measure::relative, 200, 198.9, 0.005, ""}.passed()));
  EXPECT_TRUE((Check{"", "", Measure::absolute, 2, 2.5, 0.5, ""}.passed()));
  EXPECT_FALSE((Check{"", "", Measure::absolute, 0, -1e-300, 0, ""}.passed()));
  EXPECT_TRUE((Check{"", "", Measure::at_least, 50, 50, 0, ""}.passed()));
  EXPECT_FALSE((Check{"", "", Measure::at_most, 50, 50.1, 0, ""}.passed()));
}

}  // namespace
}  // namespace reamsim::verify
