// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The surface of a bone: its form, the depth of what was reamed, and its tiles.
#include <gtest/gtest.h>

#include <array>
#include <map>

#include "render/surface/bone_surface.h"
#include "tests/render/ball_surface.h"

namespace reamsim::test {
namespace {

TEST(BoneSurfaceTest, ABallIsRoundAndNothingOfItIsReamed) {
  const BoneSurface surface = surface_of(ball());
  double volume_mm3 = 0;
  const auto all = vertices(surface);
  for (const Vertex& v : all) {
    EXPECT_NEAR(v.position_mm.norm(), 10, 0.25);
    EXPECT_GT(v.normal.dot(v.position_mm.normalized()), 0.985);
    EXPECT_EQ(v.reamed, 0);
    EXPECT_NEAR(v.density, 1.2, 1e-5);
    EXPECT_GT(v.open, 0.9);
  }
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    const Vec3& a = all[surface.indices[i]].position_mm;
    volume_mm3 += a.dot(all[surface.indices[i + 1]].position_mm.cross(all[surface.indices[i + 2]].position_mm)) / 6;
  }
  EXPECT_NEAR(volume_mm3, 4.18879 * 1000, 60) << "also wrong when the triangles face inwards";
}

TEST(BoneSurfaceTest, PartialVoxelsAtTheSurfaceAreNotReamedAndMakeItRounder) {
  const FilledVoxmap voxmap = smooth_ball();
  const BoneSurface surface = surface_of(voxmap, voxmap.fill);
  EXPECT_EQ(surface.deepest_mm, 0);
  for (const Vertex& v : vertices(surface)) {
    EXPECT_NEAR(v.position_mm.norm(), 10, 0.08);  // 0.25 above, of whole voxels
    EXPECT_EQ(v.reamed, 0);
  }
}

TEST(BoneSurfaceTest, DepthIsMeasuredFromPartialVoxelsToo) {
  const FilledVoxmap before = smooth_ball();
  FilledVoxmap voxmap = before;
  const VoxelGrid& grid = voxmap.grid;
  for_each_bone_voxel(before, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t fill) {
    const double left = std::clamp((6 - grid.center_mm({0, 0, voxel.z()}).z()) / grid.voxel_mm + 0.5, 0.0, 1.0);
    voxmap.fill.set(voxel, std::min(fill, static_cast<std::uint16_t>(std::lround(left * FillBricks::kWhole))));
  });
  const BoneSurface surface = surface_of(voxmap, before.fill);
  EXPECT_NEAR(surface.deepest_mm, 4, 0.1);
  for (const Vertex& v : vertices(surface)) {
    EXPECT_TRUE(v.position_mm.z() >= 4 || v.reamed < 0.25) << v.position_mm.transpose();
  }
}

TEST(BoneSurfaceTest, ACutIsReamedAndAsDeepAsItLiesBelowTheOldSurface) {
  FilledVoxmap voxmap = ball();
  plane_off(voxmap.grid, 6, voxmap.fill);
  const BoneSurface surface = surface_of(voxmap);
  EXPECT_NEAR(surface.deepest_mm, 4, 0.25);  // the ball's top voxels end at 9.8 mm
  int on_the_cut = 0;
  for (const Vertex& v : vertices(surface)) {
    if (v.position_mm.z() < 4) {
      EXPECT_LT(v.reamed, 0.25);
    }
    if (v.position_mm.head<2>().norm() > 4) continue;  // away from the cut's edge
    if (v.position_mm.z() < 0) continue;
    ++on_the_cut;
    EXPECT_NEAR(v.position_mm.z(), 6, 0.05);
    EXPECT_GT(v.reamed, 0.6);
    EXPECT_NEAR(v.depth_mm, 10 - v.position_mm.norm(), 0.25);
    EXPECT_GT(v.normal.z(), 0.998);
  }
  EXPECT_GT(on_the_cut, 150);
}

TEST(BoneSurfaceTest, APilotHoleIsNoSurfaceToMeasureDepthFrom) {
  FilledVoxmap voxmap = ball();
  const VoxelGrid& grid = voxmap.grid;
  for (int k = 0; k < grid.dims.z(); ++k) {
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        const Vec3 p = grid.center_mm({i, j, k});
        if (p.z() > -3 && p.head<2>().norm() < 1.25) voxmap.grade.set({i, j, k}, 0);
      }
    }
  }
  plane_off(voxmap.grid, 6, voxmap.fill);
  int round_the_hole = 0;
  for (const Vertex& v : vertices(surface_of(voxmap))) {
    const double radius = v.position_mm.head<2>().norm();
    if (v.position_mm.z() < 5.8 || radius < 1.9 || radius > 2.6) continue;
    ++round_the_hole;
    EXPECT_NEAR(v.depth_mm, 10 - v.position_mm.norm(), 0.5);
  }
  EXPECT_GT(round_the_hole, 10);
}

TEST(BoneSurfaceTest, TheFarSideOfAThinPlateDoesNotCount) {
  VoxelGrid grid;
  grid.voxel_mm = 0.5;
  grid.dims = Vec3i(48, 48, 24);
  FilledVoxmap plate(grid);  // 4 mm of bone, 3 mm of it reamed away in the middle
  for (int k = 4; k < 12; ++k) {
    for (int j = 4; j < 44; ++j) {
      for (int i = 4; i < 44; ++i) {
        plate.grade.set({i, j, k}, 150);
        if (k >= 6 && std::hypot(i - 23.5, j - 23.5) < 12) plate.fill.set({i, j, k}, 0);
      }
    }
  }
  int on_the_floor = 0;
  for (const Vertex& v : vertices(surface_of(plate))) {
    if (std::hypot(v.position_mm.x() - 12, v.position_mm.y() - 12) > 4 || v.normal.z() < 0.9) continue;
    ++on_the_floor;
    EXPECT_NEAR(v.depth_mm, 3, 0.2);
  }
  EXPECT_GT(on_the_floor, 50);
}

/// A beam of 192 x 40 x 30 mm, hollow inside or not, into whose upper face a ball of 12 mm radius was cut 8 mm deep.
double depth_of_cut_beam_mm(bool hollow) {
  VoxelGrid grid;
  grid.voxel_mm = 1;
  grid.dims = Vec3i(200, 48, 40);
  FilledVoxmap beam(grid);
  const Vec3i first(4, 4, 4), last(195, 43, 33), wall(4, 8, 6);
  for_each_voxel(first, last, [&](const Vec3i& v) {
    const bool inside = ((v - first - wall).array() >= 0).all() && ((last - wall - v).array() >= 0).all();
    if (hollow && inside) return;
    beam.grade.set(v, 150);
    if ((grid.center_mm(v) - Vec3(100, 24, 38)).norm() < 12) beam.fill.set(v, 0);
  });
  return UnreamedSurface(beam, FillBricks(grid.dims), beam.fill).deepest_mm;
}

TEST(BoneSurfaceTest, DepthIsMeasuredFromTheOuterSurfaceAlsoWhereACavityIsOpened) {
  EXPECT_NEAR(depth_of_cut_beam_mm(false), 8, 0.3);
  // At the edge of the opening, 6 mm deep, less a voxel; from the walls of the cavity it would be half of that.
  EXPECT_NEAR(depth_of_cut_beam_mm(true), 5, 0.5);
}

/// The depth of a hole that is drilled through the wall of a hollow ball.
double depth_of_drilled_shell_mm(bool ball_inside) {
  VoxelGrid grid;
  grid.voxel_mm = 1;
  grid.dims = Vec3i::Constant(48);
  FilledVoxmap shell(grid);
  for_each_voxel(Vec3i::Zero(), Vec3i::Constant(47), [&](const Vec3i& v) {
    const Vec3 p = grid.center_mm(v) - Vec3::Constant(24);
    if (p.norm() > 20 || (p.norm() < 15 && !(ball_inside && p.norm() < 6))) return;
    shell.grade.set(v, 150);
    if (p.z() > 0 && p.head<2>().norm() < 5) shell.fill.set(v, p.norm() > 10 ? 0 : FillBricks::kWhole);
  });
  return UnreamedSurface(shell, FillBricks(grid.dims), shell.fill).deepest_mm;
}

TEST(BoneSurfaceTest, APieceInACavityIsNoOuterSurface) {
  EXPECT_NEAR(depth_of_drilled_shell_mm(false), 5, 1);
  EXPECT_EQ(depth_of_drilled_shell_mm(true), depth_of_drilled_shell_mm(false));
}

TEST(BoneSurfaceTest, ADeepHoleInThickBoneHasItsDepth) {
  VoxelGrid grid;
  grid.voxel_mm = 1;
  grid.dims = Vec3i(104, 104, 96);
  FilledVoxmap block(grid);
  for_each_voxel({2, 2, 2}, {101, 101, 89}, [&](const Vec3i& v) {
    block.grade.set(v, 150);
    if (v.z() == 89) block.fill.set(v, FillBricks::kWhole / 5);  // the top is at 89.2 mm
  });
  const FillBricks before = block.fill;
  for_each_voxel({2, 2, 66}, {101, 101, 89}, [&](const Vec3i& v) {
    if ((grid.center_mm(v) - Vec3(52, 52, 0)).head<2>().norm() < 10) block.fill.set(v, 0);
  });
  EXPECT_NEAR(UnreamedSurface(block, before, block.fill).deepest_mm, 23.2, 0.2);
}

TEST(BoneSurfaceTest, FollowingChangesGivesTheSameSurfaceAsStartingAfresh) {
  FilledVoxmap last = ball();
  plane_off(last.grid, 6.3, last.fill);
  const UnreamedSurface unreamed(last, FillBricks(last.grid.dims), last.fill);
  const FilledVoxmap voxmap = ball();
  BoneFields fields(voxmap, voxmap.fill, unreamed);
  for (const double height : {8.0, 6.3}) {
    plane_off(voxmap.grid, height, fields.fill);
    fields.update();
  }
  const BoneSurface followed = BoneTiles(fields).whole();
  const BoneSurface fresh = surface_of(last);
  EXPECT_EQ(followed.vertices, fresh.vertices);
  EXPECT_EQ(followed.indices, fresh.indices);
}

/// The triangles of a surface by their corners' places in 1/1000 mm, in one order.
std::vector<std::array<long, 9>> triangles_of(const BoneSurface& surface) {
  std::vector<std::array<long, 9>> out;
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    std::array<std::array<long, 3>, 3> corners{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const float* v = surface.vertices.data() + BoneSurface::kStride * surface.indices[i + corner];
      for (std::size_t axis = 0; axis < 3; ++axis) corners[corner][axis] = std::lround(1000 * v[axis]);
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    std::array<long, 9> flat{};
    for (std::size_t k = 0; k < 9; ++k) flat[k] = corners[k / 3][k % 3];
    out.push_back(flat);
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// The edges that are not shared by two triangles passing them in opposite directions.
int open_edges(const BoneSurface& surface) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> passes;
  for (std::size_t i = 0; i < surface.indices.size(); ++i) {
    const std::uint32_t from = surface.indices[i], to = surface.indices[i % 3 == 2 ? i - 2 : i + 1];
    passes[std::minmax(from, to)] += from < to ? 1 : -1;
  }
  return static_cast<int>(std::ranges::count_if(passes, [](const auto& edge) { return edge.second != 0; }));
}

/// Largest difference of the attributes of vertices at the same places (to 1/1000 mm).
double worst_attribute(const BoneSurface& a, const BoneSurface& b) {
  std::map<std::array<long, 3>, const float*> places;
  for (std::size_t i = 0; i < a.vertices.size(); i += BoneSurface::kStride) {
    const float* v = a.vertices.data() + i;
    places[{std::lround(1000 * v[0]), std::lround(1000 * v[1]), std::lround(1000 * v[2])}] = v;
  }
  double worst = 0;
  for (std::size_t i = 0; i < b.vertices.size(); i += BoneSurface::kStride) {
    const float* v = b.vertices.data() + i;
    const auto at = places.find({std::lround(1000 * v[0]), std::lround(1000 * v[1]), std::lround(1000 * v[2])});
    if (at == places.end()) return 1e9;
    for (int k = 3; k < 10; ++k) worst = std::max(worst, std::abs(double{v[k]} - at->second[k]));
  }
  return worst;
}

TEST(BoneTilesTest, TogetherTheyAreTheWholeSurfaceAlsoAfterChanges) {
  constexpr double kVoxel_mm = 0.25;  // four tiles along each axis, more than are meshed together
  FilledVoxmap last = smooth_ball(kVoxel_mm);
  plane_off(last.grid, 6.3, last.fill);
  const UnreamedSurface unreamed(last, FillBricks(last.grid.dims), last.fill);
  const FilledVoxmap voxmap = smooth_ball(kVoxel_mm);
  BoneFields fields(voxmap, voxmap.fill, unreamed);
  BoneTiles tiles(fields);
  EXPECT_EQ(open_edges(tiles.whole()), 0);
  for (const double height : {8.0, 6.3}) {
    plane_off(voxmap.grid, height, fields.fill);
    const auto renewed = tiles.update(fields, fields.update());
    EXPECT_GT(renewed.size(), 0U);
    const BoneTiles afresh(fields);
    EXPECT_EQ(open_edges(tiles.whole()), 0);
    EXPECT_EQ(triangles_of(tiles.whole()), triangles_of(afresh.whole()));
    EXPECT_LT(worst_attribute(afresh.whole(), tiles.whole()), 1e-3);
    EXPECT_NEAR(tiles.deepest_mm(), afresh.deepest_mm(), 1e-3);
  }
}

TEST(BoneSurfaceTest, TheFloorOfAPitIsDarkerThanAFreeFace) {
  FilledVoxmap voxmap = ball();
  const VoxelGrid& grid = voxmap.grid;
  for (int k = 0; k < grid.dims.z(); ++k) {
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        const Vec3 p = grid.center_mm({i, j, k});
        if (p.z() > 0 && p.head<2>().norm() < 4) voxmap.grade.set({i, j, k}, 0);
      }
    }
  }
  double pit = 1;
  double face = 0;
  for (const Vertex& v : vertices(surface_of(voxmap))) {
    if (v.position_mm.head<2>().norm() < 2 && std::abs(v.position_mm.z()) < 1) pit = std::min(pit, v.open);
    if (v.position_mm.z() < -9) face = std::max(face, v.open);
  }
  EXPECT_LT(pit, 0.75);
  EXPECT_GT(face, 0.9);
}

}  // namespace
}  // namespace reamsim::test
