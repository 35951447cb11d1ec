// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Which parts of a surface are left out of a picture, against each of their triangles.
#include "render/gl/scene.h"

#include <gtest/gtest.h>

#include <random>

namespace reamsim {
namespace {

constexpr unsigned kTileSeed = 20261122;

using Random = std::mt19937;

double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Vec3 direction(Random& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

/// A part of a sphere: 8 x 8 squares, each of two triangles, round `middle`, outward.
BoneSurface patch(const Vec3& center_mm, double radius_mm, const Vec3& middle, double width_mm) {
  const Vec3 u = middle.unitOrthogonal();
  const Vec3 v = middle.cross(u);
  constexpr std::uint32_t kSquares = 8;
  BoneSurface out;
  for (std::uint32_t i = 0; i <= kSquares; ++i) {
    for (std::uint32_t j = 0; j <= kSquares; ++j) {
      const Vec3 at = radius_mm * middle + width_mm * ((i / 8.0 - 0.5) * u + (j / 8.0 - 0.5) * v);
      const Vec3 point = center_mm + radius_mm * at.normalized();
      for (const double value : point) out.vertices.push_back(static_cast<float>(value));
      out.vertices.resize(out.vertices.size() + BoneSurface::kStride - 3);
      if (i == kSquares || j == kSquares) continue;
      const std::uint32_t a = i * (kSquares + 1) + j, b = a + kSquares + 1;
      out.indices.insert(out.indices.end(), {a, b, a + 1, b, b + 1, a + 1});
    }
  }
  return out;
}

Camera any_camera(Random& random) {
  Camera camera;
  camera.width_px = 400;
  camera.height_px = 300;
  camera.mm_per_px = between(random, 0.02, 0.2);
  camera.depth_range_mm = 60;
  camera.eye_from_bone = Rigid::Identity();
  camera.eye_from_bone.linear() =
      Eigen::Quaterniond(Eigen::Vector4d(direction(random).homogeneous()).normalized()).toRotationMatrix();
  camera.eye_from_bone.translation() = between(random, 0, 8) * direction(random);
  const double kind = between(random, 0, 1);
  if (kind < 0.4) camera.eye_mm = between(random, 65, 200);
  if (kind > 0.8) {
    camera.cut_plane = Eigen::Vector4d::Zero();
    camera.cut_plane->head<3>() = direction(random);
    camera.cut_plane->w() = between(random, -5, 5);
  }
  return camera;
}

Vec3 corner(const BoneSurface& surface, std::size_t index) {
  return Eigen::Map<const Eigen::Vector3f>(surface.vertices.data() + surface.indices[index] * BoneSurface::kStride)
      .cast<double>();
}

/// Would this triangle colour a pixel? Decided from where its corners fall.
bool is_seen(const std::array<Vec3, 3>& corners, const Camera& camera) {
  if (camera.cut_plane) {
    const auto cut = [&](const Vec3& p) { return camera.cut_plane->head<3>().dot(p) + camera.cut_plane->w() < 0; };
    if (std::ranges::all_of(corners, cut)) return false;
  }
  std::array<Vec2, 3> px;
  for (std::size_t i = 0; i < 3; ++i) px[i] = camera.pixel(corners[i]);
  for (const int axis : {0, 1}) {
    const double size = axis == 0 ? camera.width_px : camera.height_px;
    if (std::ranges::all_of(px, [&](const Vec2& p) { return p[axis] < 0; })) return false;
    if (std::ranges::all_of(px, [&](const Vec2& p) { return p[axis] > size; })) return false;
  }
  const Vec2 a = px[1] - px[0], b = px[2] - px[0];
  // y goes down, so a triangle that faces the viewer goes clockwise here.
  return camera.cut_plane.has_value() || a.x() * b.y() - a.y() * b.x() < 0;
}

TEST(TileBoundsTest, WhatIsLeftOutIsNotInThePicture) {
  std::cout << "seed " << kTileSeed << '\n';
  Random random(kTileSeed);
  int left_out = 0;
  int unseen = 0;
  constexpr int kTrials = 4000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double radius_mm = between(random, 2, 60);
    const Vec3 middle = direction(random);
    const Vec3 at = between(random, 0, 25) * direction(random);
    const BoneSurface surface =
        patch(at - radius_mm * middle, radius_mm, middle, between(random, 0.5, std::min(8.0, radius_mm)));
    const Camera camera = any_camera(random);
    bool seen = false;
    for (std::size_t i = 0; i < surface.indices.size() && !seen; i += 3) {
      seen = is_seen({corner(surface, i), corner(surface, i + 1), corner(surface, i + 2)}, camera);
    }
    const bool kept = may_be_visible(tile_bounds(surface), camera);
    ASSERT_TRUE(kept || !seen) << "trial " << trial;
    unseen += seen ? 0 : 1;
    left_out += kept ? 0 : 1;
  }
  EXPECT_GT(unseen, kTrials / 4);
  EXPECT_LT(unseen, kTrials * 3 / 4);
  EXPECT_GT(left_out, unseen * 3 / 4) << "of " << unseen << " unseen ones";
}

TEST(TileBoundsTest, ASurfaceThatTurnsRoundIsNeverLeftOutForFacingAway) {
  // Two patches back to back.
  BoneSurface both = patch({0, 0, -20}, 20, Vec3::UnitZ(), 6);
  const BoneSurface other = patch({0, 0, 18}, 20, -Vec3::UnitZ(), 6);
  const auto offset = static_cast<std::uint32_t>(both.vertices.size() / BoneSurface::kStride);
  both.vertices.insert(both.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const std::uint32_t index : other.indices) both.indices.push_back(offset + index);
  Camera camera;
  camera.width_px = camera.height_px = 100;
  camera.depth_range_mm = 60;
  for (const Vec3& towards : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0)}) {
    camera.eye_from_bone.linear() = smallest_rotation(towards, Vec3::UnitZ()).toRotationMatrix();
    EXPECT_TRUE(may_be_visible(tile_bounds(both), camera)) << towards.transpose();
  }
}

}  // namespace
}  // namespace reamsim
