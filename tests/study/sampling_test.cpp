// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "sim/study/study_plan.h"

namespace reamsim::test {
namespace {

using Points = std::vector<std::vector<double>>;

constexpr SampleMethod kAll[] = {SampleMethod::sobol, SampleMethod::latin_hypercube, SampleMethod::monte_carlo};

TEST(UnitPoints, LieInTheOpenCubeAndDependOnTheSeed) {
  for (const SampleMethod method : kAll) {
    const Points points = unit_points(method, 100, 3, 1);
    ASSERT_EQ(points.size(), 100U);
    for (const auto& point : points) {
      ASSERT_EQ(point.size(), 3U);
      for (const double u : point) EXPECT_TRUE(u > 0 && u < 1) << u;
    }
    EXPECT_EQ(points, unit_points(method, 100, 3, 1));
    EXPECT_NE(points, unit_points(method, 100, 3, 2));
  }
}

TEST(UnitPoints, ALargerNumberOnlyAddsPoints) {
  for (const SampleMethod method : {SampleMethod::sobol, SampleMethod::monte_carlo, SampleMethod::saltelli}) {
    Points more = unit_points(method, 64, 4, 5);
    const Points fewer = unit_points(method, 16, 4, 5);
    more.resize(fewer.size());
    EXPECT_EQ(more, fewer);
  }
}

TEST(UnitPoints, LatinHypercubesAndSobolHaveOnePointInEachInterval) {
  constexpr int kPoints = 64;
  for (const SampleMethod method : {SampleMethod::latin_hypercube, SampleMethod::sobol}) {
    const Points points = unit_points(method, kPoints, 5, 3);
    for (std::size_t d = 0; d < 5; ++d) {
      std::set<int> intervals;
      for (const auto& point : points) intervals.insert(static_cast<int>(kPoints * point[d]));
      // The digital shift keeps the intervals of the first 2^k points of a Sobol sequence, but for its missing origin.
      EXPECT_GE(intervals.size(), method == SampleMethod::sobol ? kPoints - 1U : kPoints) << "dimension " << d;
    }
  }
}

TEST(UnitPoints, SobolIntegratesAProductBetterThanRandomPoints) {
  // The product of all 2u has the mean 1 over the cube.
  const auto rms_error = [](SampleMethod method) {
    constexpr int kSeeds = 16;
    double squares = 0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      double sum = 0;
      for (const auto& point : unit_points(method, 1024, 4, seed)) {
        double product = 1;
        for (const double u : point) product *= 2 * u;
        sum += product;
      }
      squares += std::pow(sum / 1024 - 1, 2);
    }
    return std::sqrt(squares / kSeeds);
  };
  // Of random points: the standard deviation of the product, √((4/3)⁴ − 1), over √1024.
  EXPECT_NEAR(rms_error(SampleMethod::monte_carlo), 0.0459, 0.02);
  EXPECT_LT(rms_error(SampleMethod::sobol), 0.005);
}

TEST(UnitPoints, SaltelliHasTheMatricesAAndBAndTheirMixtures) {
  const Points points = unit_points(SampleMethod::saltelli, 8, 3, 1);
  ASSERT_EQ(points.size(), 8U * 5);
  for (std::size_t i = 0; i < points.size(); i += 5) {
    for (std::size_t mixed = 0; mixed < 3; ++mixed) {
      for (std::size_t d = 0; d < 3; ++d) EXPECT_EQ(points[i + 2 + mixed][d], points[i + (d == mixed ? 1 : 0)][d]);
    }
  }
}

TEST(Distributions, HaveTheirMoments) {
  constexpr int kPoints = 4096;
  const Points points = unit_points(SampleMethod::latin_hypercube, kPoints, 1, 2);
  const auto moments = [&](const Distribution& distribution, bool logarithm) {
    double sum = 0, squares = 0;
    for (const auto& point : points) {
      double x = sample_number(distribution, point[0]);
      if (logarithm) x = std::log(x);
      sum += x;
      squares += x * x;
    }
    const double mean = sum / kPoints;
    return std::pair{mean, std::sqrt(squares / kPoints - mean * mean)};
  };
  using Kind = Distribution::Kind;
  const auto [mean, sd] = moments({Kind::normal, 3, 0.5}, false);
  EXPECT_NEAR(mean, 3, 1e-3);
  EXPECT_NEAR(sd, 0.5, 1e-3);
  const auto [log_mean, log_sd] = moments({Kind::lognormal, 0.15, 0.3}, true);
  EXPECT_NEAR(log_mean, std::log(0.15), 1e-3);
  EXPECT_NEAR(log_sd, 0.3, 1e-3);
  const auto [middle, spread] = moments({Kind::uniform, 2, 4}, false);
  EXPECT_NEAR(middle, 3, 1e-3);
  EXPECT_NEAR(spread, 2 / std::sqrt(12), 1e-3);
}

TEST(Distributions, TiltsRotateByTheirAngle) {
  for (const Vec3& direction : {Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.6, -0.5, 0.6)}) {
    const Vec3 before = direction.normalized(), after = tilted(direction, 3, -4);
    EXPECT_NEAR(after.norm(), 1, 1e-12);
    EXPECT_NEAR(std::acos(before.dot(after)) * 180 / std::numbers::pi, 5, 1e-9);
    EXPECT_TRUE(tilted(direction, 0, 0).isApprox(before));
    // The two rotations are about axes across each other.
    const Vec3 first = tilted(direction, 0.01, 0) - before, second = tilted(direction, 0, 0.01) - before;
    EXPECT_NEAR(first.normalized().dot(second.normalized()), 0, 1e-3);
  }
}

}  // namespace
}  // namespace reamsim::test
