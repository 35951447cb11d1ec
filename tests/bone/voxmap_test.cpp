// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxmap/voxmap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "bone_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::ElementsAre;

TEST(FillBricks, WholeUntilSet) {
  FillBricks fill({9, 8, 17});
  EXPECT_EQ(fill.brick_dims(), Vec3i(2, 1, 3));
  EXPECT_EQ(fill.stored_bricks(), 0U);
  EXPECT_EQ(fill.get({8, 7, 16}), FillBricks::kWhole);
  EXPECT_EQ(fill.brick({1, 0, 2}), nullptr);
  fill.set({8, 7, 16}, FillBricks::kWhole);
  EXPECT_EQ(fill.stored_bricks(), 0U) << "setting what is so already stores nothing";
  EXPECT_TRUE(fill.take_changed().empty());
}

TEST(FillBricks, BehavesAsADenseArray) {
  constexpr unsigned kSeed = 3;
  const Vec3i dims(19, 11, 23);
  FillBricks fill(dims);
  const VoxelGrid grid{dims, 1.0, Vec3::Zero()};
  std::vector<std::uint16_t> dense(static_cast<std::size_t>(grid.size()), FillBricks::kWhole);
  std::mt19937 random(kSeed);
  for (int i = 0; i < 3000; ++i) {
    const auto index = static_cast<std::int64_t>(random() % dense.size());
    const auto value = static_cast<std::uint16_t>(random());
    dense[static_cast<std::size_t>(index)] = value;
    fill.set(grid.coord(index), value);
  }
  for (std::int64_t i = 0; i < grid.size(); ++i) ASSERT_EQ(fill.get(grid.coord(i)), dense[static_cast<std::size_t>(i)]);
}

TEST(FillBricks, SaysWhichBricksChanged) {
  FillBricks fill({24, 24, 24});
  fill.set({17, 0, 0}, 5);
  fill.set({0, 9, 16}, 7);
  fill.set({1, 9, 16}, 7);
  EXPECT_THAT(fill.take_changed(), ElementsAre(Vec3i(2, 0, 0), Vec3i(0, 1, 2)));
  EXPECT_TRUE(fill.take_changed().empty());
  fill.set({17, 0, 0}, 5);
  EXPECT_TRUE(fill.take_changed().empty()) << "the same value is no change";
  fill.set({17, 0, 0}, FillBricks::kWhole);
  EXPECT_THAT(fill.take_changed(), ElementsAre(Vec3i(2, 0, 0)));
  const auto* brick = fill.brick({0, 1, 2});
  ASSERT_NE(brick, nullptr);
  EXPECT_EQ((*brick)[static_cast<std::size_t>(BrickLattice::offset_of({1, 9, 16}))], 7);
}

TEST(Voxmap, CountsWhatIsLeft) {
  FilledVoxmap voxmap(VoxelGrid{{10, 10, 10}, 0.5, Vec3::Zero()});
  EXPECT_EQ(voxmap.count_bone(), 0);
  for (int x = 0; x < 4; ++x) voxmap.grade.set({x, 2, 3}, 100);
  voxmap.fill.set({0, 2, 3}, 0);
  voxmap.fill.set({1, 2, 3}, 13107);  // a fifth
  voxmap.fill.set({9, 9, 9}, 5);      // air: means nothing
  EXPECT_EQ(voxmap.count_bone(), 3);
  EXPECT_NEAR(voxmap.bone_mm3(), 2.2 * 0.125, 1e-12);
}

TEST(FitToBone, LeavesTheMarginAndWholeBricks) {
  FilledVoxmap voxmap(VoxelGrid{{40, 40, 40}, 0.5, {1, 2, 3}});
  voxmap.frame = "test";
  voxmap.grade.set({20, 21, 22}, 7);
  voxmap.grade.set({39, 21, 22}, 9);
  voxmap.fill.set({39, 21, 22}, 1234);
  const FilledVoxmap fitted = fit_to_bone(voxmap, 3);
  EXPECT_EQ(fitted.grid.dims, Vec3i(32, 8, 8));
  EXPECT_EQ(fitted.frame, "test");
  for (const Vec3i& v : {Vec3i(20, 21, 22), Vec3i(39, 21, 22)}) {
    const Vec3 center = voxmap.grid.center_mm(v);
    EXPECT_EQ(grade_at(fitted, center), grade_at(voxmap, center));
    EXPECT_EQ(fitted.fill.get(fitted.grid.voxel_of(center)), voxmap.fill.get(v));
  }
  EXPECT_EQ(fitted.count_bone(), 2);
  EXPECT_EQ(fitted.grade.get({3, 3, 3}), 7);
}

TEST(FitToBone, NoBoneIsAnError) {
  const FilledVoxmap air(VoxelGrid{{8, 8, 8}, 1, Vec3::Zero()});
  EXPECT_THAT(input_error([&] { fit_to_bone(air, 2); }), ::testing::HasSubstr("no bone"));
}

}  // namespace
}  // namespace reamsim::test
