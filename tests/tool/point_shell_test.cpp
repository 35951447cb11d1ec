// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Morton codes, the triangle-box test, and what a point shell promises about the surface it samples.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "sim/base/error.h"
#include "sim/tool/distance_grid.h"
#include "sim/tool/point_shell.h"
#include "sim/tool/profile.h"
#include "tests/tool/reamer_files.h"

namespace reamsim::test {
namespace {

constexpr unsigned kSeed = 20200318;

Vec3 point_of(const PointShell& shell, std::uint64_t code) {
  return shell.origin_mm + shell.cell_mm * (morton_decode(code).cast<double>().array() + 0.5).matrix();
}

TEST(Morton, PutsXInBitZero) {
  EXPECT_EQ(morton_encode(1, 0, 0), 1u);
  EXPECT_EQ(morton_encode(0, 1, 0), 2u);
  EXPECT_EQ(morton_encode(0, 0, 1), 4u);
  EXPECT_EQ(morton_encode(1023, 1023, 1023), (1u << 30) - 1) << "the paper's 32-bit codes up to 1024";
  constexpr std::uint32_t kLast = (1u << 21) - 1;
  EXPECT_EQ(morton_encode(kLast, kLast, kLast), (std::uint64_t{1} << 63) - 1);
}

TEST(Morton, RoundTrips) {
  for (std::uint32_t v = 0; v < 1024; ++v) {
    EXPECT_EQ(rs_compact_wide_bits(spread_bits(v)), static_cast<int>(v));
    const Vec3i cell = morton_decode(morton_encode(v, 1023 - v, (v * 7) % 1024));
    EXPECT_EQ(cell, Vec3i(static_cast<int>(v), static_cast<int>(1023 - v), static_cast<int>((v * 7) % 1024)));
  }
  for (int bit = 0; bit < 21; ++bit) {
    const std::uint32_t v = 1u << bit;
    EXPECT_EQ(morton_encode(v, 0, 0), std::uint64_t{1} << (3 * bit));
    EXPECT_EQ(morton_decode(morton_encode(v, v - 1, 0x1fffff - v)),
              Vec3i(static_cast<int>(v), static_cast<int>(v - 1), static_cast<int>(0x1fffff - v)));
  }
}

/// A point of the triangle, uniform.
Vec3 sample(const Vec3& a, const Vec3& b, const Vec3& c, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  double u = unit(random), v = unit(random);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return a + u * (b - a) + v * (c - a);
}

TEST(TriangleBox, AgreesWithBruteForceSampling) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-1.6, 1.6);
  const auto vector = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  const Vec3 half(0.5, 0.4, 0.7);
  int touching = 0, apart = 0;
  for (int i = 0; i < 600; ++i) {
    const Vec3 a = vector(), b = vector(), c = vector(), center = 0.3 * vector();
    const bool claimed = triangle_touches_box(a, b, c, center, half);
    // Distance in units of "box grown by": 0 inside. Sampling shows contact for sure, absence only up to its density.
    double nearest = 1e9;
    for (int s = 0; s < 4000; ++s) {
      const Vec3 beyond = ((sample(a, b, c, random) - center).cwiseAbs() - half).cwiseMax(0.0);
      nearest = std::min(nearest, beyond.maxCoeff());
    }
    if (nearest == 0) {
      EXPECT_TRUE(claimed) << "triangle " << i;
    }
    if (nearest > 0.15) {
      EXPECT_FALSE(claimed) << "triangle " << i << " is " << nearest << " away";
    }
    (claimed ? touching : apart) += 1;
  }
  EXPECT_GT(touching, 100);
  EXPECT_GT(apart, 100);
}

TEST(TriangleBox, KnowsTheHardCases) {
  const Vec3 half = Vec3::Constant(0.5);
  const auto touches = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    return triangle_touches_box(a, b, c, Vec3::Zero(), half);
  };
  EXPECT_TRUE(touches({-9, -9, 0.1}, {9, -9, 0.1}, {0, 9, 0.1})) << "no corner inside, the box pierces it";
  EXPECT_TRUE(touches({0.5, -1, -1}, {0.5, 1, -1}, {0.5, 0, 2})) << "in the plane of a face";
  EXPECT_TRUE(touches({0.5, 0.5, 0.5}, {2, 2, 0.5}, {2, 2, 2})) << "one corner";
  EXPECT_FALSE(touches({1.1, 0, 0}, {0, 1.1, 0}, {1.1, 1.1, 0})) << "passes a vertical edge";
  EXPECT_FALSE(touches({1.6, 0, 0}, {0, 1.6, 0}, {0, 0, 1.6})) << "passes a corner: x + y + z > 1.5";
  EXPECT_TRUE(touches({1.4, 0, 0}, {0, 1.4, 0}, {0, 0, 1.4}));
}

class ShellOf : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Reamers, ShellOf, testing::Values("convex", "convex_edges", "flat"),
                         [](const auto& reamer_name) { return std::string(reamer_name.param); });

/// Codes as a set: whether a cell is in the shell.
bool contains(const PointShell& shell, const Vec3i& cell) {
  if ((cell.array() < 0).any() || (cell.array() >= shell.resolution).any()) return false;
  const std::uint64_t code = morton_encode(cell.x(), cell.y(), cell.z());
  return std::binary_search(shell.codes.begin(), shell.codes.end(), code);
}

TEST_P(ShellOf, EverySurfacePointLiesInACellOfTheShell) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  const TriangleMesh mesh = reamer(GetParam());
  const PointShell shell = voxelize_surface(mesh, 96);
  std::mt19937 random(kSeed);
  int missing = 0;
  for (const auto& t : mesh.triangles)
    for (int s = 0; s < 5; ++s) {
      const Vec3 p = sample(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], random);
      const Vec3 cell = (p - shell.origin_mm) / shell.cell_mm;
      missing += contains(shell, cell.array().floor().cast<int>()) ? 0 : 1;
    }
  EXPECT_EQ(missing, 0);
}

TEST_P(ShellOf, EveryCellIsTouchedByTheSurface) {
  constexpr int kSide = 14;
  const TriangleMesh mesh = reamer(GetParam());
  const PointShell shell = voxelize_surface(mesh, kSide);
  // By brute force over all triangles, so with another walk than the one under test.
  const Vec3 half = Vec3::Constant(0.5 * shell.cell_mm);
  std::size_t touched = 0;
  Vec3i cell;
  for (cell.x() = 0; cell.x() < kSide; ++cell.x())
    for (cell.y() = 0; cell.y() < kSide; ++cell.y())
      for (cell.z() = 0; cell.z() < kSide; ++cell.z()) {
        const Vec3 center = point_of(shell, morton_encode(cell.x(), cell.y(), cell.z()));
        const bool touches = std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) {
          return triangle_touches_box(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], center, half);
        });
        touched += touches ? 1 : 0;
        // Exactly on a cell's face, rounding decides; only clear cases count.
        if (touches != contains(shell, cell)) {
          const bool grown = std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) {
            return triangle_touches_box(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], center,
                                        half * (1 + 1e-9));
          });
          const bool shrunk = std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) {
            return triangle_touches_box(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], center,
                                        half * (1 - 1e-9));
          });
          EXPECT_NE(grown, shrunk) << "cell " << cell.transpose();
        }
      }
  EXPECT_NEAR(static_cast<double>(touched), static_cast<double>(shell.codes.size()),
              0.01 * static_cast<double>(touched));
}

TEST(PointShell, PointsOfASphereLieWithinHalfACellDiagonal) {
  Profile profile;
  for (int i = 0; i <= 90; ++i) {
    const double angle = std::numbers::pi * i / 90;
    profile.points.emplace_back(i == 0 || i == 90 ? 0.0 : 10 * std::sin(angle), 10 - 10 * std::cos(angle));
  }
  const PointShell shell = voxelize_surface(revolve(profile, 256), 64);
  const double limit = 0.5 * std::sqrt(3.0) * shell.cell_mm + 10 * (1 - std::cos(std::numbers::pi / 180)) + 1e-3;
  for (const std::uint64_t code : shell.codes)
    EXPECT_LT(std::abs((point_of(shell, code) - Vec3(0, 0, 10)).norm() - 10), limit);
  // A surface of area A meets about 1.5·A/h² cells: each axis sees its projection, averaged over directions.
  const double expected = 1.5 * 4 * std::numbers::pi * 100 / (shell.cell_mm * shell.cell_mm);
  EXPECT_NEAR(static_cast<double>(shell.codes.size()) / expected, 1, 0.05);
}

TEST(PointShell, CodesAscendAndTheCuttingEndIsSampledWhereItIs) {
  const PointShell shell = voxelize_surface(reamer("flat"), 128);
  EXPECT_TRUE(std::is_sorted(shell.codes.begin(), shell.codes.end(), std::less_equal<>()));
  double lowest = 1e9;
  for (const std::uint64_t code : shell.codes) lowest = std::min(lowest, point_of(shell, code).z());
  EXPECT_NEAR(lowest, 0, 1e-9);
  EXPECT_NEAR(shell.cell_mm, 27.0 / 127, 1e-6);
}

TEST(PointShell, WorksAtBothEndsOfTheResolution) {
  EXPECT_EQ(voxelize_surface(reamer("flat"), 1).codes.size(), 1u);
  const PointShell finest = voxelize_surface(reamer("flat"), 1024);
  EXPECT_GT(finest.codes.size(), 3'000'000u);
  EXPECT_LT(finest.codes.back(), 1u << 30);
  // A needle, so that the finest shell of all stays small: about 1.5·A/h² cells.
  const double radius = 0.05, length = 10;
  const PointShell needle =
      voxelize_surface(revolve({{{0, 0}, {radius, 0}, {radius, length}, {0, length}}}, 128), 4096);
  const double area = 2 * std::numbers::pi * radius * (length + radius);
  EXPECT_NEAR(static_cast<double>(needle.codes.size()) * std::pow(needle.cell_mm, 2) / (1.5 * area), 1, 0.2);
  EXPECT_EQ(morton_decode(needle.codes.back()).z(), 4095);
  EXPECT_TRUE(std::is_sorted(needle.codes.begin(), needle.codes.end(), std::less_equal<>()));
}

TEST(PointShell, RefusesOtherResolutions) {
  for (const int m : {-1, 0, 4097}) EXPECT_THROW(voxelize_surface(reamer("flat"), m), InputError);
  EXPECT_THROW(voxelize_surface({}, 64), InputError);
}

}  // namespace
}  // namespace reamsim::test
