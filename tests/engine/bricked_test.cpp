// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What is particular to `bricked`: its memory plan, pools, cells and lists.
#include <array>
#include <iostream>
#include <set>

#include "sim/base/error.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/common/engine.h"
#include "sim/engine/common/tables.h"
#include "sim/tool/point_shell.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::bricked_tests {
namespace {

TEST(Bricked, BricksInManyPoolsGiveTheSame) {
  for (const KernelShape shape : {KernelShape::cpu, KernelShape::gpu}) {
    for (const ErosionMode erosion : {ErosionMode::remove, ErosionMode::wear}) {
      SCOPED_TRACE(name_of(shape) + ", " + name_of(erosion));
      SimulationInput scene = oblique_scene("auto");
      scene.scenario.engine.tuning.kernel_shape = shape;
      scene.scenario.cutting.erosion = erosion;
      const Outcome one = run(scene);
      EXPECT_GT(one.removed.size(), 100U);
      // 120 bricks in pools of 8 or, with fill, of 8 larger ones.
      const std::size_t largest = erosion == ErosionMode::wear ? 14'000 : 6'000;
      const auto engine = make_bricked_engine(cl::Device(cl::choose_device("auto")), scene.scenario, scene.bone,
                                              scene.tool, {.largest_pool = largest});
      expect_same(run_on(*engine, scene), one);
      engine->restore(scene.bone);
      expect_same(run_on(*engine, scene), one);
      EXPECT_THROW(make_bricked_engine(cl::Device(cl::choose_device("auto")), scene.scenario, scene.bone, scene.tool,
                                       {.largest_pool = 700}),
                   InputError)
          << "16 pools of a brick each do not hold 120";
    }
  }
}

/// Records that the voxels of a run take: one for each frame and block of 4×4×4 voxels.
std::size_t records_of(const RemovedFrames& removed, const VoxelGrid& grid) {
  std::set<std::array<int, 4>> records;
  for (const auto& [voxel, frame] : removed) {
    const Vec3i block = grid.coord(voxel) / 4;
    records.insert({block.x(), block.y(), block.z(), frame});
  }
  return records.size();
}

TEST(Bricked, AShortListOfRemovedVoxelsGivesTheSame) {
  for (const KernelShape shape : {KernelShape::cpu, KernelShape::gpu}) {
    for (const CuttingLaw law : {CuttingLaw::energy, CuttingLaw::per_point}) {
      SCOPED_TRACE(name_of(shape) + ", " + name_of(law));
      SimulationInput scene = oblique_scene("auto");
      scene.scenario.engine.tuning.kernel_shape = shape;
      scene.scenario.cutting.law = law;
      scene.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 20);
      const Outcome roomy = run(scene);
      // Room for what one substep could remove, which the run, a single batch, removes several times over.
      EXPECT_GT(records_of(roomy.removed, scene.bone.voxmap->grid), 2 * scene.tool.shell.codes.size());
      const auto engine = make_bricked_engine(cl::Device(cl::choose_device("auto")), scene.scenario, scene.bone,
                                              scene.tool, {.removed_room = 1});
      expect_same(run_on(*engine, scene), roomy);
    }
  }
}

TEST(Bricked, WhatDoesNotFitSaysWhatWould) {
  cl::DeviceInfo info = cl::choose_device("auto");
  info.global_memory_bytes = 50'000;
  const SimulationInput scene = oblique_scene("auto");
  try {
    make_bricked_engine(cl::Device(info), scene.scenario, scene.bone, scene.tool);
    FAIL() << "it fits";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("bone.voxel_mm"), std::string::npos) << text;
    EXPECT_NE(text.find("would fit"), std::string::npos) << text;
  }
}

TEST(Bricked, MemoryFollowsTheBoneAndNotTheLattice) {
  // A block in the corner of a lattice of 1024³: a dense array takes 1074 MB.
  FilledVoxmap voxmap(VoxelGrid{Vec3i::Constant(1024), 0.05, Vec3::Zero()});
  for (int z = 0; z < 64; ++z)
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) voxmap.grade.set({x, y, z}, 100);
  const Tool tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 61);
  EXPECT_EQ(voxmap.grade.stored_bricks(), 512U);
  // 8.4 MB of it the table that finds bricks.
  EXPECT_LT(device_bricks_bytes(voxmap, FillStore::none) + 3 * tool.shell.codes.size(), 12'000'000U);
}

TEST(ShellCells, HoldEveryPointOnceWithinTheirBounds) {
  const Tool tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 150);
  for (const int side : {1, 2, 8, 16, 32}) {
    const ShellCells shell = make_shell_cells(tool.shell, side);
    std::vector<std::uint64_t> codes;
    for (const ShellCell& cell : shell.cells) {
      EXPECT_EQ(cell.begin % 16, 0U);
      for (rs_u32 i = cell.begin; i < cell.begin + cell.count; ++i) {
        const int offset = shell.offsets[i];
        const int at[3] = {offset & 31, offset >> 5 & 31, offset >> 10};
        for (int axis = 0; axis < 3; ++axis) EXPECT_LE(at[axis], cell.span[axis]);
        codes.push_back(morton_encode(static_cast<std::uint32_t>(cell.first[0] + at[0]),
                                      static_cast<std::uint32_t>(cell.first[1] + at[1]),
                                      static_cast<std::uint32_t>(cell.first[2] + at[2])));
      }
    }
    EXPECT_EQ(codes, tool.shell.codes) << "side " << side;
  }
}

TEST(ShellCells, ACellFitsTheWindowHoweverItIsTurned) {
  for (const double ratio : {0.1, 0.4721, 0.9, 1.0, 1.7, 4.0, 16.0}) {
    const int side = shell_cell_side(ratio);
    EXPECT_TRUE(side == 1 || (side - 1) * ratio * std::sqrt(3.0) < 28) << ratio;
    EXPECT_TRUE(side == 32 || (2 * side - 1) * ratio * std::sqrt(3.0) > 27.9) << ratio << " could be larger";
  }
}

}  // namespace
}  // namespace reamsim::test::bricked_tests
