#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <random>

#include "render/surface/bone_tiles.h"
#include "render/surface/surface_smoothing.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/sample_voxels.h"

namespace reamsim {
namespace {

/// A ball of radius 10 mm about the origin, 0.5 mm voxels, whole voxels by their centres.
FilledVoxmap ball() {
  VoxelGrid grid;
  grid.voxel_mm = 0.5;
  grid.dims = Vec3i(46, 45, 47);  // no multiples of a brick
  grid.origin_mm = Vec3(-11.5, -11.2, -11.7);
  FilledVoxmap voxmap(grid);
  for (int k = 0; k < grid.dims.z(); ++k) {
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        if (grid.center_mm({i, j, k}).norm() < 10) voxmap.grade.set({i, j, k}, 150);
      }
    }
  }
  return voxmap;
}

/// Takes away what lies above z = `height`, by fractions.
void plane_off(const VoxelGrid& grid, double height_mm, FillBricks& fill) {
  for (int k = 0; k < grid.dims.z(); ++k) {
    const double left = std::clamp((height_mm - grid.center_mm({0, 0, k}).z()) / grid.voxel_mm + 0.5, 0.0, 1.0);
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        fill.set({i, j, k}, static_cast<std::uint16_t>(std::lround(left * FillBricks::kWhole)));
      }
    }
  }
}

struct Vertex {
  Vec3 position_mm;
  Vec3 normal;
  double depth_mm, reamed, density, open;
};

std::vector<Vertex> vertices(const BoneSurface& surface) {
  std::vector<Vertex> out;
  for (std::size_t i = 0; i < surface.vertices.size(); i += BoneSurface::kStride) {
    const float* v = surface.vertices.data() + i;
    out.push_back({{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, v[6], v[7], v[8], v[9]});
  }
  return out;
}

/// Of a bone that began with the fill `before`.
BoneSurface surface_of(const FilledVoxmap& voxmap, const FillBricks& before) {
  const UnreamedSurface unreamed(voxmap, before, voxmap.fill);
  return make_bone_surface(BoneFields(voxmap, voxmap.fill, unreamed));
}

/// Of a bone that began whole.
BoneSurface surface_of(const FilledVoxmap& voxmap) {
  return surface_of(voxmap, FillBricks(voxmap.grid.dims));
}

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

/// The ball with partial voxels at its surface.
FilledVoxmap smooth_ball() {
  FilledVoxmap voxmap = ball();
  const auto distance = [](const Vec3& point) { return point.norm() - 10; };
  const auto sample = [&](const Vec3i& voxel, std::uint8_t) -> SurfaceVoxel {
    const Vec3 center = voxmap.grid.center_mm(voxel);
    return {fraction_inside(distance, center, voxmap.grid.voxel_mm), 150};
  };
  set_partial_fill(sample, voxmap);
  return voxmap;
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
  // From the wall, which goes down, to the ball, which falls off by 30 degrees.
  const double uneven = uneven_normals(surface_of(voxmap, before), edge, {std::sqrt(0.75), 0.5}, voxmap.grid.voxel_mm);
  std::cout << "normals at the edge uneven by " << uneven << "\n";
  EXPECT_LT(uneven, 0.065);
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
  const BoneSurface followed = make_bone_surface(fields);
  const BoneSurface fresh = surface_of(last);
  EXPECT_EQ(followed.vertices, fresh.vertices);
  EXPECT_EQ(followed.indices, fresh.indices);
}

/// The triangles of a surface by their corners' places in 1/1000 mm, in one order.
std::vector<std::array<long, 9>> triangles_of(const BoneSurface& surface) {
  std::vector<std::array<long, 9>> out;
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    std::array<std::array<long, 3>, 3> corners;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const float* v = surface.vertices.data() + BoneSurface::kStride * surface.indices[i + corner];
      for (std::size_t axis = 0; axis < 3; ++axis) corners[corner][axis] = std::lround(1000 * v[axis]);
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    std::array<long, 9> flat;
    for (std::size_t k = 0; k < 9; ++k) flat[k] = corners[k / 3][k % 3];
    out.push_back(flat);
  }
  std::sort(out.begin(), out.end());
  return out;
}

BoneSurface joined(const BoneTiles& tiles) {
  BoneSurface out;
  for (const BoneSurface& tile : tiles.surfaces()) {
    const auto first = static_cast<std::uint32_t>(out.vertices.size() / BoneSurface::kStride);
    out.vertices.insert(out.vertices.end(), tile.vertices.begin(), tile.vertices.end());
    for (const std::uint32_t index : tile.indices) out.indices.push_back(first + index);
  }
  return out;
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
  FilledVoxmap last = smooth_ball();
  plane_off(last.grid, 6.3, last.fill);
  const UnreamedSurface unreamed(last, FillBricks(last.grid.dims), last.fill);
  const FilledVoxmap voxmap = smooth_ball();
  BoneFields fields(voxmap, voxmap.fill, unreamed);
  BoneTiles tiles(fields);
  EXPECT_EQ(triangles_of(joined(tiles)), triangles_of(make_bone_surface(fields)));
  for (const double height : {8.0, 6.3}) {
    plane_off(voxmap.grid, height, fields.fill);
    const auto renewed = tiles.update(fields, fields.update());
    EXPECT_GT(renewed.size(), 0U);
    const BoneSurface whole = make_bone_surface(fields);
    EXPECT_EQ(triangles_of(joined(tiles)), triangles_of(whole));
    EXPECT_LT(worst_attribute(whole, joined(tiles)), 1e-3);
    EXPECT_NEAR(tiles.deepest_mm(), whole.deepest_mm, 1e-3);
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
}  // namespace reamsim
