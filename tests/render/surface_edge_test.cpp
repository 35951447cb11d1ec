// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The edge of a reamed face, and the smoothing that makes it even.
#include <gtest/gtest.h>

#include <functional>
#include <iostream>
#include <map>
#include <numeric>
#include <random>

#include "render/surface/bone_surface.h"
#include "tests/render/ball_surface.h"

namespace reamsim::test {
namespace {

/// Where the edge of the reamed face crosses the edges of the triangles.
std::vector<Vec3> reamed_edge(const BoneSurface& surface) {
  const std::vector<Vertex> all = vertices(surface);
  std::vector<Vec3> out;
  for (std::size_t i = 0; i < surface.indices.size(); ++i) {
    const Vertex& a = all[surface.indices[i]];
    const Vertex& b = all[surface.indices[i % 3 == 2 ? i - 2 : i + 1]];
    if ((a.reamed < 0.5) == (b.reamed < 0.5)) continue;
    const double t = (0.5 - a.reamed) / (b.reamed - a.reamed);
    out.emplace_back(a.position_mm + t * (b.position_mm - a.position_mm));
  }
  return out;
}

/// Root mean square of the distances of points about the z axis from a circle of their mean radius.
double out_of_round_mm(const std::vector<Vec3>& points, double& mean_mm) {
  double sum = 0;
  double squares = 0;
  for (const Vec3& p : points) sum += p.head<2>().norm();
  mean_mm = sum / static_cast<double>(points.size());
  for (const Vec3& p : points) squares += std::pow(p.head<2>().norm() - mean_mm, 2);
  return std::sqrt(squares / static_cast<double>(points.size()));
}

/// The partial voxels of a ball after everything outside of `kept` (negative there, mm) was removed, and before.
std::pair<FilledVoxmap, FillBricks> reamed_ball(const FilledVoxmap& whole,
                                                const std::function<double(const Vec3&)>& kept) {
  FilledVoxmap voxmap = whole;
  const VoxelGrid& grid = voxmap.grid;
  for_each_bone_voxel(whole, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t fill) {
    const double left = std::clamp(0.5 - kept(grid.center_mm(voxel)) / grid.voxel_mm, 0.0, 1.0);
    voxmap.fill.set(voxel, std::min(fill, static_cast<std::uint16_t>(std::lround(left * FillBricks::kWhole))));
  });
  return {voxmap, whole.fill};
}

struct Cut {
  const char* name;
  std::function<double(const Vec3&)> kept;  ///< negative where bone is kept, mm
  double rim_mm;                            ///< radius of the edge of the cut
};

const std::vector<Cut> kCuts{
    {"plane, 17 degrees", [](const Vec3& p) { return p.z() - 3; }, std::sqrt(91.0)},
    {"plane, 37 degrees", [](const Vec3& p) { return p.z() - 6; }, 8},
    {"plane, 58 degrees", [](const Vec3& p) { return p.z() - 8.5; }, std::sqrt(100 - 8.5 * 8.5)},
    {"pocket with a steep wall", [](const Vec3& p) { return std::min(p.z() - 5, 5 - p.head<2>().norm()); }, 5},
    {"pocket of a ball", [](const Vec3& p) { return 6 - (p - Vec3(0, 0, 12)).norm(); },
     std::sqrt(36 - std::pow((144 + 36 - 100) / 24.0, 2))}};

// Fractions of partly removed material that were cut off at 1 within half a triangle, read beside the surface,
// scalloped the edge.
TEST(BoneSurfaceTest, TheEdgeOfTheReamedFaceIsRound) {
  for (const Cut& cut : kCuts) {
    const auto [voxmap, before] = reamed_ball(smooth_ball(), cut.kept);
    double mean_mm = 0;
    const double off_mm = out_of_round_mm(reamed_edge(surface_of(voxmap, before)), mean_mm);
    const double voxel_mm = voxmap.grid.voxel_mm;
    std::cout << cut.name << ": rim " << cut.rim_mm << " mm, edge " << mean_mm << " mm, out of round by "
              << off_mm / voxel_mm << " voxels\n";
    EXPECT_LT(off_mm, 0.05 * voxel_mm) << cut.name;
    EXPECT_NEAR(mean_mm, cut.rim_mm, 1.2 * voxel_mm) << cut.name;
  }
}

/// Root mean square of the differences of the normals of triangles round a circular edge from their means in the same
/// place across it: teeth along it. `edge` and the direction `across` it: distance from the axis and height, mm.
double uneven_normals(const BoneSurface& surface, const Vec2& edge, const Vec2& across, double voxel_mm) {
  std::map<int, std::vector<Vec3>> normals;  // radial, tangential, upward
  double count = 0;
  const std::vector<Vertex> all_vertices = vertices(surface);
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    Vec3 middle = Vec3::Zero();
    Vec3 normal = Vec3::Zero();
    for (std::size_t corner = 0; corner < 3; ++corner) {
      middle += all_vertices[surface.indices[i + corner]].position_mm / 3;
      normal += all_vertices[surface.indices[i + corner]].normal;
    }
    normal.normalize();
    const Vec3 out = Vec3(middle.x(), middle.y(), 0).normalized();
    const Vec2 away = Vec2(middle.dot(out), middle.z()) - edge;
    if (away.norm() > 1.5 * voxel_mm) continue;
    normals[static_cast<int>(std::floor(4 * away.dot(across) / voxel_mm))].emplace_back(
        normal.dot(out), normal.dot(Vec3::UnitZ().cross(out)), normal.z());
    ++count;
  }
  double squares = 0;
  for (const auto& [bin, all] : normals) {
    const Vec3 mean = std::accumulate(all.begin(), all.end(), Vec3(Vec3::Zero())) / static_cast<double>(all.size());
    for (const Vec3& normal : all) squares += (normal - mean).squaredNorm();
  }
  return std::sqrt(squares / count);
}

// Smoothed towards the face on either side, normals at the edge alternated along it: bright and dark teeth.
TEST(BoneSurfaceTest, TheEdgeOfTheReamedFaceHasNoTeeth) {
  const Cut& cut = kCuts[3];
  const auto [voxmap, before] = reamed_ball(smooth_ball(), cut.kept);
  const Vec2 edge(cut.rim_mm, std::sqrt(100 - cut.rim_mm * cut.rim_mm));
  // From the wall, which is vertical, to the ball, which slopes by 30 degrees.
  const double uneven = uneven_normals(surface_of(voxmap, before), edge, {std::sqrt(0.75), 0.5}, voxmap.grid.voxel_mm);
  std::cout << "normals at the edge uneven by " << uneven << "\n";
  EXPECT_LT(uneven, 0.065);
}

/// A square of side 10 in uneven triangles: vertices of a lattice that are moved at random.
struct UnevenSquare {
  static constexpr int kSide = 11;

  UnevenSquare() {
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<float> shift(-0.35F, 0.35F);
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        points.emplace_back(static_cast<float>(i) + shift(random), static_cast<float>(j) + shift(random), 0.0F);
      }
    }
    for (int j = 0; j + 1 < kSide; ++j) {
      for (int i = 0; i + 1 < kSide; ++i) {
        const auto a = static_cast<std::uint32_t>(i + kSide * j);
        const std::uint32_t b = a + 1, c = a + kSide, d = c + 1;
        for (const std::uint32_t corner : {a, b, d, a, d, c}) indices.push_back(corner);
      }
    }
  }
  /// So far from the edge that the edge's vertices, which have too few neighbours, come to nothing in `rounds`.
  [[nodiscard]] static bool inside(std::size_t vertex, int rounds) {
    const int i = static_cast<int>(vertex) % kSide, j = static_cast<int>(vertex) / kSide;
    return std::min({i, j, kSide - 1 - i, kSide - 1 - j}) > rounds;
  }

  static constexpr unsigned kSeed = 7;
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint32_t> indices;
};

TEST(SurfaceSmoothing, WhatChangesEvenlyIsLeftAloneOnUnevenTriangles) {
  constexpr int kRounds = 3;
  const UnevenSquare square;
  const Neighbours neighbours(square.points.size(), square.indices);
  const std::vector<float> ones(square.points.size(), 1);
  std::vector<float> slope;
  for (const Eigen::Vector3f& p : square.points) slope.push_back(2 * p.x() - 3 * p.y() + 5);
  std::vector<float> even = slope;
  std::vector<float> equal = slope;
  smooth_values(neighbours, mean_value_weights(neighbours, square.points), ones, even, kRounds);
  smooth_values(neighbours, std::vector<float>(neighbours.count(), 1), ones, equal, kRounds);
  float worst_equal = 0;
  for (std::size_t i = 0; i < slope.size(); ++i) {
    if (!UnevenSquare::inside(i, kRounds)) continue;
    EXPECT_NEAR(even[i], slope[i], 1e-4) << "vertex " << i << ", seed " << UnevenSquare::kSeed;
    worst_equal = std::max(worst_equal, std::abs(equal[i] - slope[i]));
  }
  EXPECT_GT(worst_equal, 0.3F) << "equal weights would move the lines";
}

TEST(SurfaceSmoothing, NoiseIsEvenedOut) {
  const UnevenSquare square;
  const Neighbours neighbours(square.points.size(), square.indices);
  std::vector<float> values;
  for (std::size_t i = 0; i < square.points.size(); ++i) values.push_back(i % 2 == 0 ? 1.0F : -1.0F);
  smooth_values(neighbours, mean_value_weights(neighbours, square.points), std::vector<float>(values.size(), 1), values,
                4);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (UnevenSquare::inside(i, 4)) {
      EXPECT_LT(std::abs(values[i]), 0.3F) << "vertex " << i;
    }
  }
}

}  // namespace
}  // namespace reamsim::test
