// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/load_bone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>

#include "sim/mesh/mesh_io.h"
#include "tests/cli/data_files.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/temp_dir.h"

namespace {

/// The most bytes that one allocation may take: a test of what happens without memory lowers it.
std::atomic<std::size_t> most_bytes{std::numeric_limits<std::size_t>::max()};

}  // namespace

// Inlined, GCC takes the pair new and free() for a mistake.
[[gnu::noinline]] void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return bytes > most_bytes ? nullptr : std::malloc(bytes == 0 ? 1 : bytes);
}
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  void* const memory = operator new(bytes, std::nothrow);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace reamsim::test {
namespace {

BoneSettings block_scan(const TempDir& dir) {
  const std::string path = dir.path() + "/scan.nrrd";
  std::ofstream(path, std::ios::binary) << block_nrrd();
  BoneSettings settings;
  settings.source = BoneSource::ct;
  settings.side = BodySide::left;
  settings.voxel_mm = 1;
  settings.ct.path = path;
  settings.glenoid.center_mm = Vec3(14.5, 10, 10);
  settings.glenoid.normal = Vec3(1, 0, 0);
  settings.glenoid.superior = Vec3(0, 0, 1);
  return settings;
}

/// The bone of the cache is that of load_bone(), and so is what is said of it.
void expect_as_loaded(BoneCache& bones, const BoneSettings& settings) {
  Diagnostics of_cache, of_loading;
  const Bone cached = bones.load(settings, of_cache);
  const Bone loaded = load_bone(settings, of_loading);
  EXPECT_EQ(cached.voxmap->grade, loaded.voxmap->grade);
  EXPECT_EQ(cached.view().bone_mm3(), loaded.view().bone_mm3());
  ASSERT_EQ(cached.glenoid.has_value(), loaded.glenoid.has_value());
  EXPECT_TRUE(cached.glenoid->bone_from_glenoid.isApprox(loaded.glenoid->bone_from_glenoid, 0));
  EXPECT_EQ(of_cache.notes, of_loading.notes);
  EXPECT_EQ(of_cache.warnings, of_loading.warnings);
  if (loaded.segmentation) {
    EXPECT_EQ(cached.segmentation->planes_through_mm, loaded.segmentation->planes_through_mm);
  }
}

/// How many bones the cache has loaded, this one included.
int loaded(BoneCache& bones, const BoneSettings& settings) {
  Diagnostics report;
  bones.load(settings, report);
  return bones.loaded();
}

TEST(BoneCache, RunsWithTheSameBoneShareItsVoxels) {
  BoneSettings settings;
  settings.source = BoneSource::phantom;
  settings.side = BodySide::left;
  settings.voxel_mm = 1;
  settings.phantom.shape = PhantomShape::glenoid;
  BoneCache bones;
  EXPECT_EQ(loaded(bones, settings), 1);
  EXPECT_EQ(loaded(bones, settings), 1);
  expect_as_loaded(bones, settings);
  settings.phantom.version_deg += 5;
  EXPECT_EQ(loaded(bones, settings), 2);
  expect_as_loaded(bones, settings);
}

TEST(BoneCache, ReamingOneRunLeavesTheBoneOfTheNext) {
  BoneSettings settings;
  settings.source = BoneSource::phantom;
  settings.voxel_mm = 1;
  settings.phantom.shape = PhantomShape::sphere;
  BoneCache bones;
  Diagnostics report;
  Bone bone = bones.load(settings, report);
  const double whole_mm3 = bone.view().bone_mm3();
  bone.fill.set(bone.voxmap->grid.voxel_of({0, 0, 0}), 0);
  ASSERT_LT(bone.view().bone_mm3(), whole_mm3);
  EXPECT_EQ(bones.load(settings, report).view().bone_mm3(), whole_mm3);
}

TEST(BoneCache, OneScanMayHaveSeveralGlenoidFramesWhereASeedIsGiven) {
  const TempDir dir;
  BoneSettings settings = block_scan(dir);
  settings.ct.seed_mm = Vec3(10, 10, 10);
  BoneCache bones;
  EXPECT_EQ(loaded(bones, settings), 1);
  settings.glenoid.center_mm = Vec3(14.5, 11, 10);
  EXPECT_EQ(loaded(bones, settings), 1);
  expect_as_loaded(bones, settings);
  settings.ct.seed_mm.reset();  // now the planes of the segmentation go through the glenoid
  EXPECT_EQ(loaded(bones, settings), 2);
  expect_as_loaded(bones, settings);
  settings.glenoid.center_mm = Vec3(14.5, 10, 10);
  expect_as_loaded(bones, settings);
}

TEST(BoneCache, AChangedFileIsLoadedAgain) {
  const TempDir dir;
  const BoneSettings settings = block_scan(dir);
  BoneCache bones;
  EXPECT_EQ(loaded(bones, settings), 1);
  EXPECT_EQ(loaded(bones, settings), 1);
  std::filesystem::last_write_time(settings.ct.path,
                                   std::filesystem::last_write_time(settings.ct.path) + std::chrono::seconds(2));
  EXPECT_EQ(loaded(bones, settings), 2);
}

TEST(BoneCache, WhatWasSaidBeforeMemoryEndedIsKept) {
  const TempDir dir;
  // The table of bricks of the lattice around two cubes, 50 mm apart along each axis, takes more than 1 MB.
  TriangleMesh mesh = box_mesh({0, 0, 0}, {3, 3, 3});
  const TriangleMesh other = box_mesh({50, 50, 50}, {52, 52, 52});
  for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({a + 8, b + 8, c + 8});
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  write_stl(dir.path() + "/bone.stl", mesh);
  BoneSettings settings;
  settings.source = BoneSource::mesh;
  settings.voxel_mm = 0.1;
  settings.mesh.path = dir.path() + "/bone.stl";
  BoneCache bones;
  Diagnostics report;
  most_bytes = 1'000'000;
  EXPECT_THROW(bones.load(settings, report), std::bad_alloc);
  most_bytes = std::numeric_limits<std::size_t>::max();
  EXPECT_THAT(report.warnings, ::testing::Contains(::testing::HasSubstr("a piece besides the largest")));
}

}  // namespace
}  // namespace reamsim::test
