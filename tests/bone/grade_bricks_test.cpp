// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxmap/sparse_bricks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "sim/bone/voxmap/sample_voxels.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim::test {
namespace {

using ::testing::ElementsAre;

/// No side is a multiple of a brick.
const Vec3i kDims(19, 11, 23);

/// A lattice's grades in the plainest form there is.
struct DenseGrades {
  VoxelGrid grid{kDims, 1.0, Vec3::Zero()};
  std::vector<std::uint8_t> grade = std::vector<std::uint8_t>(static_cast<std::size_t>(grid.size()), 0);

  [[nodiscard]] std::int64_t count() const {
    return grid.size() - std::count(grade.begin(), grade.end(), std::uint8_t{0});
  }
};

void expect_same(const GradeBricks& bricks, const DenseGrades& dense) {
  for (std::int64_t e = 0; e < dense.grid.size(); ++e) {
    ASSERT_EQ(bricks.get(dense.grid.coord(e)), dense.grade[static_cast<std::size_t>(e)]) << e;
  }
  EXPECT_EQ(bricks.count(), dense.count());
}

TEST(GradeBricks, AirUntilSet) {
  GradeBricks grades({9, 8, 17});
  EXPECT_EQ(grades.brick_dims(), Vec3i(2, 1, 3));
  EXPECT_EQ(grades.stored_bricks(), 0U);
  EXPECT_EQ(grades.get({8, 7, 16}), 0);
  EXPECT_EQ(grades.brick({1, 0, 2}), nullptr);
  grades.set({8, 7, 16}, 0);
  EXPECT_EQ(grades.stored_bricks(), 0U) << "setting what is so already stores nothing";
  grades.set({8, 7, 16}, 3);
  ASSERT_NE(grades.brick({1, 0, 2}), nullptr);
  EXPECT_EQ((*grades.brick({1, 0, 2}))[static_cast<std::size_t>(BrickLattice::offset_of({8, 7, 16}))], 3);
  EXPECT_EQ(grades.count(), 1);
}

TEST(GradeBricks, BehavesAsADenseArray) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE("seed 5");
  std::mt19937 random(kSeed);
  GradeBricks bricks(kDims);
  DenseGrades dense;
  for (int round = 0; round < 20; ++round) {
    // Now more is added than taken away, now the other way round, so that bricks come and go.
    const unsigned air_in_eight = round % 2 == 0 ? 2 : 7;
    for (int i = 0; i < 2000; ++i) {
      const auto e = static_cast<std::size_t>(random()) % dense.grade.size();
      const auto grade = static_cast<std::uint8_t>(random() % 8 < air_in_eight ? 0 : 1 + random() % 250);
      dense.grade[e] = grade;
      bricks.set(dense.grid.coord(static_cast<std::int64_t>(e)), grade);
    }
    expect_same(bricks, dense);
  }
}

TEST(GradeBricks, ForgetsABrickThatBecameAir) {
  GradeBricks grades({24, 8, 8});
  grades.set({1, 1, 1}, 7);
  grades.set({9, 1, 1}, 8);
  grades.set({1, 1, 1}, 0);
  EXPECT_EQ(grades.stored_bricks(), 1U);
  EXPECT_EQ(grades.brick({0, 0, 0}), nullptr);
  const std::size_t bytes = grades.bytes();
  grades.set({17, 2, 3}, 9);
  EXPECT_EQ(grades.bytes(), bytes) << "the room of the old brick is taken again";
  EXPECT_EQ(grades.get({17, 1, 1}), 0) << "and nothing of it is left";
  grades.put({1, 0, 0}, {});
  EXPECT_THAT(grades.stored_coords(), ElementsAre(Vec3i(2, 0, 0)));
}

TEST(GradeBricks, VisitsStoredBricksInTheLatticesOrder) {
  GradeBricks grades(kDims);
  grades.set({18, 10, 22}, 1);
  grades.set({0, 9, 8}, 2);
  grades.set({8, 0, 8}, 3);
  EXPECT_THAT(grades.stored_coords(), ElementsAre(Vec3i(1, 0, 1), Vec3i(0, 1, 1), Vec3i(2, 1, 2)));
  std::vector<Vec3i> visited;
  grades.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& brick) {
    EXPECT_EQ(&brick, grades.brick(coord));
    visited.push_back(coord);
  });
  EXPECT_EQ(visited, grades.stored_coords());
}

TEST(GradeBricks, KnowsTheBricksAround) {
  GradeBricks grades({32, 8, 8});
  EXPECT_TRUE(bricks_near_bone(grades).empty());
  grades.set({0, 0, 0}, 1);
  grades.set({9, 0, 0}, 1);
  const std::vector<Vec3i> around = bricks_near_bone(grades);
  ASSERT_EQ(around.size(), 4U * 3 * 3) << "two bricks side by side, with one more all round, beyond the lattice too";
  EXPECT_EQ(around.front(), Vec3i(-1, -1, -1));
  EXPECT_EQ(around.back(), Vec3i(2, 1, 1));
}

TEST(GradeBricks, EqualityIsThatOfTheGrades) {
  GradeBricks a(kDims), b(kDims);
  a.set({1, 2, 3}, 4);
  a.set({18, 10, 22}, 5);
  b.set({18, 10, 22}, 5);
  EXPECT_FALSE(a == b);
  b.set({1, 2, 3}, 4);
  EXPECT_TRUE(a == b) << "whatever the order of storing";
  b.set({2, 2, 3}, 4);
  EXPECT_FALSE(a == b);
  EXPECT_FALSE(GradeBricks(kDims) == GradeBricks({25, 11, 23})) << "another lattice";
}

TEST(GradeBricks, HoldMoreThanAPage) {
  GradeBricks grades({8 * 20, 8 * 20, 8 * 21});  // 8400 bricks; a page has 512
  const auto grade = [](const Vec3i& brick) {
    return static_cast<std::uint8_t>(1 + (brick.x() + 7 * brick.y() + 31 * brick.z()) % 250);
  };
  for (int z = 0; z < 21; ++z) {
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 20; ++x) grades.set({8 * x + 3, 8 * y + 1, 8 * z + 7}, grade({x, y, z}));
    }
  }
  const GradeBricks copy = grades;
  EXPECT_EQ(copy.count(), 8400);
  copy.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
    ASSERT_EQ(copy.get(8 * coord + Vec3i(3, 1, 7)), grade(coord)) << coord.transpose();
  });
}

TEST(GradeBricks, ACopyKeepsItsValuesWhenTheOriginalChanges) {
  GradeBricks bricks({40, 16, 8});
  for (int x = 0; x < 40; x += 8) bricks.set({x, 0, 0}, 7);
  const GradeBricks before = bricks;
  GradeBricks other = bricks;
  EXPECT_EQ(bricks.brick({0, 0, 0}), before.brick({0, 0, 0})) << "memory is shared until a change";
  bricks.set({0, 0, 0}, 9);  // another value
  bricks.set({8, 0, 0}, 0);  // a brick that becomes air
  bricks.set({0, 8, 0}, 5);  // a new brick
  bricks.put({2, 0, 0}, GradeBricks::Brick{1, 2});
  other.set({0, 15, 0}, 3);
  for (int x = 0; x < 40; x += 8) EXPECT_EQ(before.get({x, 0, 0}), 7) << x;
  EXPECT_EQ(before.stored_bricks(), 5U);
  EXPECT_EQ(before.get({0, 8, 0}), 0);
  EXPECT_EQ(before.get({0, 15, 0}), 0);
  EXPECT_EQ(other.get({0, 0, 0}), 7);
  EXPECT_EQ(other.get({0, 15, 0}), 3);
  EXPECT_EQ(other.get({0, 8, 0}), 0);
  EXPECT_EQ(bricks.get({0, 0, 0}), 9);
  EXPECT_EQ(bricks.get({16, 0, 0}), 1);
}

TEST(SampleBricks, GivesWhatTheSamplerSays) {
  // A slanted slab, so that some bricks are air, some full and some mixed, over more bricks than are sampled at once.
  const Vec3i dims(21, 230, 150);
  const auto grade = [](const Vec3i& v) {
    const int height = v.x() + v.y() - v.z();
    return static_cast<std::uint8_t>(height > 0 && height < 60 ? 1 + height : 0);
  };
  const GradeBricks sampled = sample_bricks(dims, [&](const Vec3i& coord, GradeBricks::Brick& brick) {
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      if ((voxel.array() >= dims.array()).any() || grade(voxel) == 0) continue;
      brick[static_cast<std::size_t>(offset)] = grade(voxel);
    }
  });
  GradeBricks expected(dims);
  const VoxelGrid grid{dims, 1, Vec3::Zero()};
  for (std::int64_t e = 0; e < grid.size(); ++e) expected.set(grid.coord(e), grade(grid.coord(e)));
  EXPECT_TRUE(sampled == expected);
  EXPECT_EQ(sampled.bytes(), expected.bytes());
}

}  // namespace
}  // namespace reamsim::test
