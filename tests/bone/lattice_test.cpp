// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxmap/voxmap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bone_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double k24GB = 24e9;
constexpr double kPlenty = 1e15;

std::string refusal(const Eigen::Array3d& dims, double voxel_mm, const LatticeLoad& load, double memory_bytes) {
  return input_error([&] { check_lattice("bone.stl", dims, voxel_mm, load, memory_bytes); });
}

double advised_mm(const std::string& text) {
  const std::string key = "bone.voxel_mm of ";
  const std::size_t at = text.find(key);
  EXPECT_NE(at, std::string::npos) << text;
  return at == std::string::npos ? 0 : std::stod(text.substr(at + key.size()));
}

TEST(Lattice, NoSideOf1024IsALimit) {
  EXPECT_NO_THROW(check_lattice("bone", {2048, 2048, 2048}, 0.075, {.bone_fraction = 0.1}, k24GB));
  EXPECT_NO_THROW(
      check_lattice("bone", {4096, 2048, 2048}, 0.05, {.bone_fraction = 0.02, .bytes_per_voxel = 13}, k24GB));
  EXPECT_NO_THROW(check_lattice("bone", {900'000, 64, 64}, 0.01, {}, k24GB));
}

TEST(Lattice, BricksAreCountedIn31Bits) {
  const double side = 8 * 1290;  // 1290³ = 2 146 689 000 bricks
  EXPECT_NO_THROW(check_lattice("bone", {side, side, side}, 0.1, {.bone_fraction = 0}, kPlenty));
  EXPECT_THAT(refusal({side + 8, side + 8, side + 8}, 0.1, {.bone_fraction = 0}, kPlenty), HasSubstr("would fit"));
}

TEST(Lattice, NamesTheBytesAndAVoxelThatFits) {
  const Eigen::Array3d dims(4000, 4000, 4000);
  const std::string text = refusal(dims, 0.05, {}, k24GB);
  // A byte for each of 6.4e10 voxels, and eight for each of 1.25e8 bricks.
  EXPECT_THAT(text, AllOf(StartsWith("bone.stl"), HasSubstr("4000 x 4000 x 4000 voxels of 0.05 mm"),
                          HasSubstr("needs 65 GB; 12 GB are available")));
  const double fitting_mm = advised_mm(text);
  EXPECT_NO_THROW(check_lattice("bone", dims * 0.05 / fitting_mm, fitting_mm, {}, k24GB));
  EXPECT_GT(refusal(dims * 0.05 / (0.8 * fitting_mm), 0.8 * fitting_mm, {}, k24GB).size(), 0U) << "nor far too large";
}

TEST(Lattice, AThinBonesShareGrowsWithTheVoxels) {
  const Eigen::Array3d dims(20'000, 20'000, 4000);
  const LatticeLoad load{.bone_fraction = 0.01, .bytes_per_voxel = 13};
  const double fitting_mm = advised_mm(refusal(dims, 0.01, load, k24GB));
  const double factor = fitting_mm / 0.01;
  const LatticeLoad coarser{.bone_fraction = 0.01 * factor, .bytes_per_voxel = 13};
  EXPECT_NO_THROW(check_lattice("bone", dims / factor, fitting_mm, coarser, k24GB));
}

TEST(Lattice, SizesThatAreNoNumbersAreRefusedWithoutAdvice) {
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double side : {infinite, -1.0, std::nan("")}) {
    EXPECT_THAT(refusal({side, 8, 8}, 0.1, {}, kPlenty), AllOf(HasSubstr("finite size"), Not(HasSubstr("would fit"))));
  }
}

}  // namespace
}  // namespace reamsim::test
