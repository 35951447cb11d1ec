// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/vdb/bone_vdb.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetMeasure.h>
#include <tbb/global_control.h>

#include <numbers>
#include <random>

#include "bone_fixture.h"
#include "sim/bone/vdb/grids.h"
#include "sim/scene/load_bone.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

/// Bone of every grade with holes, partly reamed, from a seed; dimensions that are no multiples of a brick.
FilledVoxmap ragged_bone(unsigned seed) {
  FilledVoxmap voxmap(VoxelGrid{{21, 18, 27}, 0.3, {-4.7, 12.9, 1.0 / 3}});
  voxmap.mapping = {0.0008, -0.01, 0.55};
  voxmap.frame = "mesh";
  voxmap.layers = BoneLayers{1.0 / 3, 1.8, 0.4};
  std::mt19937 random(seed);
  for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
    if (random() % 3 == 0) continue;
    voxmap.grade.set(voxmap.grid.coord(e), static_cast<std::uint8_t>(1 + random() % 250));
    if (random() % 4 == 0) voxmap.fill.set(voxmap.grid.coord(e), static_cast<std::uint16_t>(random()));
    if (random() % 40 == 0) voxmap.fill.set(voxmap.grid.coord(e), 0);
  }
  return voxmap;
}

class BoneVdb : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }

  [[nodiscard]] std::string path(const std::string& name = "bone.vdb") const { return dir_.path() + "/" + name; }
  /// All grids of a file, by OpenVDB alone.
  static std::map<std::string, openvdb::GridBase::Ptr> grids_of(const std::string& path) {
    openvdb::io::File file(path);
    file.open(false);
    std::map<std::string, openvdb::GridBase::Ptr> out;
    for (auto name = file.beginName(); name != file.endName(); ++name) out[*name] = file.readGrid(*name);
    return out;
  }
  void write_foreign(const openvdb::GridBase::Ptr& grid, const std::string& name) const {
    grid->setName(name);
    openvdb::io::File file(path());
    file.write({grid});
  }

  TempDir dir_;
};

void expect_same(const FilledVoxmap& a, const FilledVoxmap& b) {
  EXPECT_EQ(a.grid.dims, b.grid.dims);
  EXPECT_EQ(a.grid.voxel_mm, b.grid.voxel_mm);
  EXPECT_EQ(a.grid.origin_mm, b.grid.origin_mm);
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.mapping.ash_slope_g_cm3_per_hu, b.mapping.ash_slope_g_cm3_per_hu);
  EXPECT_EQ(a.mapping.ash_offset_g_cm3, b.mapping.ash_offset_g_cm3);
  EXPECT_EQ(a.mapping.ash_fraction, b.mapping.ash_fraction);
  ASSERT_EQ(a.layers.has_value(), b.layers.has_value());
  if (a.layers) {
    EXPECT_EQ(a.layers->cortical_mm, b.layers->cortical_mm);
    EXPECT_EQ(a.layers->cortical_g_cm3, b.layers->cortical_g_cm3);
    EXPECT_EQ(a.layers->trabecular_g_cm3, b.layers->trabecular_g_cm3);
  }
  ASSERT_EQ(a.grade, b.grade);
  for (std::int64_t e = 0; e < a.grid.size(); ++e) {
    const Vec3i c = a.grid.coord(e);
    if (a.grade.get(c) == 0) continue;  // fill means nothing in air
    ASSERT_EQ(a.fill.get(c), b.fill.get(c)) << c.transpose();
  }
}

TEST_F(BoneVdb, RoundTripBitForBit) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const FilledVoxmap bone = ragged_bone(seed);
    write_bone_vdb(path(), bone, {}, {});
    const FilledVoxmap back = read_stored_bone(path()).voxmap;
    expect_same(bone, back);
    EXPECT_EQ(bone.count_bone(), back.count_bone());
    EXPECT_EQ(bone.bone_mm3(), back.bone_mm3());
  }
}

TEST_F(BoneVdb, EveryFillAndEveryGradeComesBack) {
  FilledVoxmap bone(VoxelGrid{{256, 256, 1}, 1, Vec3::Zero()});
  for (int i = 0; i < 65536; ++i) {
    bone.grade.set({i % 256, i / 256, 0}, static_cast<std::uint8_t>(1 + i % 250));
    bone.fill.set({i % 256, i / 256, 0}, static_cast<std::uint16_t>(i));
  }
  write_bone_vdb(path(), bone, {}, {});
  expect_same(bone, read_stored_bone(path()).voxmap);
}

TEST_F(BoneVdb, FourGridsWithUnitsAndProvenance) {
  const FilledVoxmap bone = ragged_bone(4);
  write_bone_vdb(path(), bone, {{7, 42}, {100, 3}}, {{"scenario", "text of it"}, {"unit", "nonsense"}});
  auto grids = grids_of(path());
  ASSERT_EQ(grids.size(), 4U);
  const std::map<std::string, std::string> units = {
      {"density", "g/cm^3"}, {"fill", "1"}, {"surface", "mm"}, {"removed_frame", "frame index"}};
  for (const auto& [name, unit] : units) {
    ASSERT_TRUE(grids[name]) << name;
    EXPECT_EQ(grids[name]->metaValue<std::string>("unit"), unit);
    EXPECT_EQ(grids[name]->metaValue<std::string>("frame"), "mesh");
    EXPECT_EQ(grids[name]->metaValue<std::string>("scenario"), "text of it");
    EXPECT_THAT(grids[name]->getCreator(), HasSubstr("reamsim "));
    EXPECT_EQ(grids[name]->metaValue<double>("ash_fraction"), 0.55);
    const openvdb::Vec3d center = grids[name]->indexToWorld(openvdb::Vec3d(3, 4, 5));
    const Vec3 truth = bone.grid.center_mm({3, 4, 5});
    EXPECT_NEAR((Vec3(center.x(), center.y(), center.z()) - truth).norm(), 0, 1e-12);
  }
  EXPECT_EQ(grids["density"]->getGridClass(), openvdb::GRID_FOG_VOLUME);
  EXPECT_EQ(grids["fill"]->getGridClass(), openvdb::GRID_FOG_VOLUME);
  EXPECT_EQ(grids["surface"]->getGridClass(), openvdb::GRID_LEVEL_SET);

  const auto removed = openvdb::gridPtrCast<openvdb::FloatGrid>(grids["removed_frame"]);
  EXPECT_EQ(removed->background(), -1.0F);
  EXPECT_EQ(removed->activeVoxelCount(), 2U);
  const Vec3i c = bone.grid.coord(7);
  EXPECT_EQ(removed->tree().getValue({c.x(), c.y(), c.z()}), 42.0F);
  EXPECT_EQ(removed->tree().getValue({0, 0, 0}), -1.0F);
  openvdb::io::File file(path());
  file.open(false);
  EXPECT_EQ(file.getMetadata()->metaValue<std::string>("scenario"), "text of it");
}

TEST_F(BoneVdb, SumOfFillIsTheBoneVolume) {
  const FilledVoxmap bone = ragged_bone(5);
  write_bone_vdb(path(), bone, {}, {});
  const auto fill = openvdb::gridPtrCast<openvdb::FloatGrid>(grids_of(path())["fill"]);
  double sum = 0;
  for (auto value = fill->cbeginValueOn(); value; ++value) sum += double{*value};
  EXPECT_NEAR(sum * bone.grid.voxel_mm3(), bone.bone_mm3(), 1e-6 * bone.bone_mm3());
}

TEST_F(BoneVdb, SurfaceIsThatOfTheSphere) {
  BoneSettings settings = phantom(PhantomShape::sphere, 0.5);
  settings.phantom.radius_mm = 8;
  Diagnostics report;
  write_bone_vdb(path(), load_bone(settings, report), {}, {});
  const auto surface = openvdb::gridPtrCast<openvdb::FloatGrid>(grids_of(path())["surface"]);
  EXPECT_NEAR(surface->background(), 1.5, 1e-6);
  const double truth_mm3 = 4.0 / 3 * std::numbers::pi * 512;
  EXPECT_NEAR(openvdb::tools::levelSetVolume(*surface), truth_mm3, 0.015 * truth_mm3);
  const auto inside = surface->worldToIndex(openvdb::Vec3d(7, 0, 0));
  EXPECT_NEAR(surface->tree().getValue(openvdb::Coord::round(inside)), -1, 0.5);
}

TEST_F(BoneVdb, SurfaceHasTheDistancesOfTheSphere) {
  BoneSettings settings = phantom(PhantomShape::sphere, 0.5);
  settings.phantom.radius_mm = 8;
  Diagnostics report;
  write_bone_vdb(path(), load_bone(settings, report), {}, {});
  const auto surface = openvdb::gridPtrCast<openvdb::FloatGrid>(grids_of(path())["surface"]);
  double sum = 0, squares = 0, worst = 0;
  int count = 0;
  for (auto value = surface->cbeginValueOn(); value; ++value) {
    const double off = double{*value} - (surface->indexToWorld(value.getCoord()).length() - 8);
    sum += off;
    squares += off * off;
    worst = std::max(worst, std::abs(off));
    ++count;
  }
  std::cout << count << " voxels: mean error " << sum / count << " mm, RMS " << std::sqrt(squares / count)
            << ", largest " << worst << '\n';
  // Distances to a mesh of the same surface, by OpenVDB: mean 0.011 mm, RMS 0.033, largest 0.080.
  EXPECT_NEAR(sum / count, 0, 0.02);
  EXPECT_LT(std::sqrt(squares / count), 0.05);
  EXPECT_LT(worst, 0.15);
}

TEST_F(BoneVdb, SurfaceFollowsTheFill) {
  // A block whose top layer is a quarter full: the surface stands lower than that of the whole block.
  BoneSettings settings = phantom(PhantomShape::half_space, 0.5);
  settings.phantom.size_mm = {12, 12, 6};
  Diagnostics report;
  FilledVoxmap bone = load_bone(settings, report).copy_voxels();
  const auto volume = [&] {
    write_bone_vdb(path(), bone, {}, {});
    return openvdb::tools::levelSetVolume(*openvdb::gridPtrCast<openvdb::FloatGrid>(grids_of(path())["surface"]));
  };
  const double whole_mm3 = volume();
  const int top = bone.grid.voxel_of({0, 0, -0.25}).z();
  for (int y = 0; y < bone.grid.dims.y(); ++y) {
    for (int x = 0; x < bone.grid.dims.x(); ++x) bone.fill.set({x, y, top}, 16384);
  }
  EXPECT_NEAR(whole_mm3 - volume(), 0.75 * 0.5 * 144, 0.2 * 0.75 * 0.5 * 144);
}

TEST_F(BoneVdb, UniformBricksAreTiles) {
  FilledVoxmap bone(VoxelGrid{{40, 24, 24}, 0.5, Vec3::Zero()});
  for (int z = 0; z < 24; ++z) {
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 36; ++x) bone.grade.set({x, y, z}, static_cast<std::uint8_t>(x < 20 ? 200 : 90));
    }
  }
  bone.fill.set({9, 9, 9}, 1000);
  write_bone_vdb(path(), bone, {}, {});
  auto grids = grids_of(path());
  const auto density = openvdb::gridPtrCast<openvdb::FloatGrid>(grids["density"]);
  const auto fill = openvdb::gridPtrCast<openvdb::FloatGrid>(grids["fill"]);
  // Of five layers of 3×3 bricks one holds two grades, and the last is half full.
  EXPECT_EQ(density->tree().leafCount(), 18U);
  EXPECT_EQ(density->tree().activeTileCount(), 27U);
  EXPECT_EQ(fill->tree().leafCount(), 10U);
  EXPECT_EQ(fill->tree().activeTileCount(), 35U);
  for (const auto& grid : {density, fill}) {
    EXPECT_EQ(grid->activeVoxelCount(), static_cast<openvdb::Index64>(bone.count_bone()));
    EXPECT_EQ(grid->tree().getValue({36, 0, 0}), 0.0F);
  }
  expect_same(bone, read_stored_bone(path()).voxmap);
}

TEST_F(BoneVdb, SurfaceDoesNotDependOnWhereTheBricksLie) {
  // A cube of ten voxels: with its corner at 7 it wraps a whole brick, the nearest that such a brick comes to a
  // surface; elsewhere no brick is whole.
  const auto surface_at = [this](int corner) {
    FilledVoxmap bone(VoxelGrid{{32, 32, 32}, 1, Vec3::Zero()});
    for (int z = 0; z < 10; ++z) {
      for (int y = 0; y < 10; ++y) {
        for (int x = 0; x < 10; ++x) bone.grade.set({corner + x, corner + y, corner + z}, 100);
      }
    }
    write_bone_vdb(path(), bone, {}, {});
    return openvdb::gridPtrCast<openvdb::FloatGrid>(grids_of(path())["surface"]);
  };
  const auto whole = surface_at(7);
  const auto parted = surface_at(12);
  EXPECT_EQ(whole->activeVoxelCount(), parted->activeVoxelCount());
  for (auto value = whole->cbeginValueOn(); value; ++value) {
    EXPECT_NEAR(*value, parted->tree().getValue(value.getCoord().offsetBy(5)), 1e-4) << value.getCoord();
  }
}

TEST_F(BoneVdb, NothingLeftIsAnEmptySurface) {
  FilledVoxmap bone(VoxelGrid{{8, 8, 8}, 1, Vec3::Zero()});
  bone.grade.set({0, 0, 0}, 100);
  bone.fill.set({0, 0, 0}, 0);
  write_bone_vdb(path(), bone, {{0, 1}}, {});
  EXPECT_EQ(grids_of(path())["surface"]->activeVoxelCount(), 0U);
  EXPECT_EQ(read_stored_bone(path()).voxmap.count_bone(), 0);
}

TEST_F(BoneVdb, GridsDoNotDependOnTheThreads) {
  BoneSettings settings = phantom(PhantomShape::glenoid, 0.8);
  Diagnostics report;
  const FilledVoxmap bone = load_bone(settings, report).copy_voxels();
  write_bone_vdb(path("many.vdb"), bone, {}, {});
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    write_bone_vdb(path("one.vdb"), bone, {}, {});
  }
  auto many = grids_of(path("many.vdb"));
  auto one = grids_of(path("one.vdb"));
  for (const auto& [name, grid] : many) {
    const auto a = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
    const auto b = openvdb::gridPtrCast<openvdb::FloatGrid>(one[name]);
    ASSERT_EQ(a->activeVoxelCount(), b->activeVoxelCount()) << name;
    auto other = b->getConstAccessor();
    for (auto value = a->cbeginValueOn(); value; ++value) ASSERT_EQ(*value, other.getValue(value.getCoord())) << name;
  }
}

TEST_F(BoneVdb, DensityAloneIsWholeBone) {
  auto grid = make_float_grid(0.0F);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  grid->tree().setValueOn({-3, 5, 7}, 1.8F);
  grid->tree().setValueOn({4, 5, 8}, 0.4F);
  write_foreign(grid, "density");
  const FilledVoxmap bone = read_stored_bone(path()).voxmap;
  EXPECT_EQ(bone.grid.dims, Vec3i(8, 1, 2));
  EXPECT_EQ(bone.grid.voxel_mm, 0.5);
  EXPECT_EQ(bone.count_bone(), 2);
  EXPECT_EQ(grade_at(bone, {-1.5, 2.5, 3.5}), 225);
  EXPECT_EQ(grade_at(bone, {2.0, 2.5, 4.0}), 50);
  EXPECT_EQ(bone.fill.stored_bricks(), 0U);
}

TEST_F(BoneVdb, RefusesOtherTransforms) {
  const auto text_for = [&](const openvdb::math::Mat4d& matrix) {
    auto grid = make_float_grid(0.0F);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    grid->tree().setValueOn({1, 1, 1}, 1.0F);
    write_foreign(grid, "density");
    return input_error([&] { read_stored_bone(path()); });
  };
  openvdb::math::Mat4d stretched = openvdb::math::Mat4d::identity();
  stretched(1, 1) = 2;
  EXPECT_THAT(text_for(stretched), HasSubstr("non-cubic"));
  openvdb::math::Mat4d turned = openvdb::math::Mat4d::identity();
  turned.setToRotation(openvdb::Vec3d(0, 0, 1), 0.1);
  EXPECT_THAT(text_for(turned), HasSubstr("rotated"));
  openvdb::math::Mat4d mirrored = openvdb::math::Mat4d::identity();
  mirrored(0, 0) = -1;
  EXPECT_THAT(text_for(mirrored), HasSubstr("mirrored"));
  openvdb::math::Mat4d metres = openvdb::math::Mat4d::identity();
  for (int axis = 0; axis < 3; ++axis) metres(axis, axis) = 0.0005;
  EXPECT_THAT(text_for(metres), HasSubstr("voxels of 0.0005 mm; expected 0.01 to 5 mm: is the grid in another unit?"));
}

TEST_F(BoneVdb, RefusesOtherContents) {
  auto absurd = make_float_grid(0.0F);
  absurd->tree().setValueOn({0, 0, 0}, 1.0F);
  absurd->tree().setValueOn({2000000000, 2000000000, -2000000000}, 1.0F);
  write_foreign(absurd, "density");
  EXPECT_THAT(input_error([&] { read_stored_bone(path()); }), HasSubstr("lattice"));

  write_foreign(make_float_grid(0.0F), "density");
  EXPECT_THAT(input_error([&] { read_stored_bone(path()); }), HasSubstr("without active voxels"));

  auto other = make_float_grid(0.0F);
  write_foreign(other, "smoke");
  EXPECT_THAT(input_error([&] { read_stored_bone(path()); }), HasSubstr("found: smoke"));

  auto wrong_type = openvdb::Int32Grid::create(0);
  wrong_type->tree().setValueOn({0, 0, 0}, 1);
  write_foreign(wrong_type, "density");
  EXPECT_THAT(input_error([&] { read_stored_bone(path()); }), HasSubstr("expected a FloatGrid"));
  write_foreign(wrong_type, "fill");
  EXPECT_THAT(input_error([&] { read_stored_bone(path()); }), HasSubstr("no grid \"density\" (found: fill)"));

  auto not_a_number = make_float_grid(0.0F);
  not_a_number->tree().setValueOn({0, 0, 0}, NAN);
  write_foreign(not_a_number, "density");
  EXPECT_THAT(input_error([&] { read_stored_bone(path()); }), HasSubstr("NaN"));
}

TEST_F(BoneVdb, WritingWhereNothingCanBeWritten) {
  const FilledVoxmap bone = ragged_bone(6);
  try {
    write_bone_vdb(path("none/bone.vdb"), bone, {}, {});
    FAIL() << "no RunError";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), HasSubstr("none/bone.vdb: cannot be written"));
  }
}

TEST_F(BoneVdb, AFailedWriteLeavesTheOldFileAndNothingElse) {
  const FilledVoxmap bone = ragged_bone(7);
  write_bone_vdb(path(), bone, {}, {});
  std::filesystem::create_directory(path("bone.vdb.tmp"));  // so that the new file cannot be made
  EXPECT_THROW(write_bone_vdb(path(), ragged_bone(8), {}, {}), RunError);
  expect_same(bone, read_stored_bone(path()).voxmap);
}

TEST_F(BoneVdb, AFullDiskIsARunError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  std::filesystem::create_symlink("/dev/full", path("full.vdb.tmp"));
  EXPECT_THROW(write_bone_vdb(path("full.vdb"), ragged_bone(9), {}, {}), RunError);
  EXPECT_FALSE(std::filesystem::exists(path("full.vdb")));
}

}  // namespace
}  // namespace reamsim::test
