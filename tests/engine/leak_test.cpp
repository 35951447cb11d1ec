// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What a point shell leaves behind: nothing at a spacing of half a voxel, and about what is warned of beyond.
#include <gtest/gtest.h>

#include <iostream>
#include <tuple>

#include "sim/tool/point_shell.h"
#include "tests/engine/sweep.h"

namespace reamsim::test::leak_tests {
namespace {

constexpr double kVoxel = 0.1;
constexpr double kRateHz = 1000;

struct Feed {
  double mm_s;
  double way_mm;  ///< short where the feed is slow
};

struct Path {
  const char* name;
  Vec3 at;         ///< a point of the block's face, where the tool's axis starts
  Vec3 inward;     ///< the face's inward normal
  Vec3 direction;  ///< of the feed
  Vec3 tilt_rad;   ///< rotation vector of the tool
};

std::ostream& operator<<(std::ostream& out, const Path& path) {
  return out << path.name;
}

std::ostream& operator<<(std::ostream& out, const Feed& feed) {
  return out << feed.mm_s << " mm/s";
}

/// From where the tool just does not touch the face, into the block.
Motion drive(const Tool& tool, const Path& path, const Feed& feed) {
  constexpr double kGap = 0.05;
  const double angle = path.tilt_rad.norm();
  const Quat tilt(Eigen::AngleAxisd(angle, angle > 0 ? Vec3(path.tilt_rad / angle) : Vec3::UnitX()));
  double foremost = -1e9;
  for (const Vec3& v : tool.mesh.vertices) foremost = std::max(foremost, (tilt * v).dot(path.inward));
  const Vec3 from = path.at - path.inward * (foremost + kGap);
  const int frames = static_cast<int>(std::ceil((feed.way_mm + kGap) / feed.mm_s * kRateHz));
  const Vec3 to = from + path.direction.normalized() * (feed.mm_s / kRateHz * frames);
  return straight(from, to, frames, kRateHz, 250, tilt);
}

const Vec3 kDown(0, 0, -1), kRight(1, 0, 0);
const Path kPaths[] = {{"plunge", {0.03, -0.02, 0}, kDown, kDown, {0, 0, 0}},
                       {"tilted_plunge", {0, 0, 0}, kDown, {0.2, -0.1, -1}, {0.3, 0.2, 0}},
                       {"sideways", {-1.8, 0.04, -0.7}, kRight, kRight, {0, 0, 0}},
                       {"tilted_sideways", {-1.8, 0, -0.7}, kRight, {1, 0.3, -0.2}, {0.1, -0.25, 0}}};
const Feed kFeeds[] = {{0.05, 0.3}, {0.2, 0.4}, {1, 0.8}, {5, 1.5}, {50, 1.5}, {300, 1.5}};

class NoLeak : public testing::TestWithParam<std::tuple<const char*, Path, Feed>> {};

std::string case_name(const testing::TestParamInfo<std::tuple<const char*, Path, Feed>>& test_case) {
  const auto& [device, path, feed] = test_case.param;
  return std::string(device) + "_" + path.name + "_" + std::to_string(std::lround(1000 * feed.mm_s)) + "_um_s";
}

INSTANTIATE_TEST_SUITE_P(Feeds, NoLeak,
                         testing::Combine(testing::Values("serial", "auto"), testing::ValuesIn(kPaths),
                                          testing::ValuesIn(kFeeds)),
                         case_name);

TEST_P(NoLeak, NothingIsLeftDeeperThanHalfAVoxel) {
  const auto& [device, path, feed] = GetParam();
  SimulationInput scene;
  scene.scenario = quiet_scenario(device);
  scene.bone.set_voxels(block({3.6, 3.6, 2}, kVoxel, 1.2));
  scene.tool = make_tool(cap_profile(6, 3, 1.2, 0.3), 61);
  ASSERT_NEAR(scene.tool.shell.cell_mm, 0.5 * kVoxel, 1e-12);
  scene.motion = drive(scene.tool, path, feed);
  const Leftovers found = ream_and_look(scene, 0.5);
  EXPECT_GT(found.swept, 30);
  EXPECT_EQ(found.left, 0) << "of " << found.swept << ", the deepest by " << found.deepest_voxels << " voxels";
}

/// Share of the swept voxels that survive a flat face driven along its axis right through a block in half-voxel steps,
/// over some turns of the tool against the block.
double measured_leak(double spacing_voxels) {
  constexpr double kRadius = 1.2, kHalfWay = 3.6;
  constexpr unsigned kSeed = 97;
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  std::int64_t swept = 0, left = 0;
  for (int turn = 0; turn < 5; ++turn) {
    SimulationInput scene;
    scene.scenario = quiet_scenario("serial");
    scene.bone.set_voxels(block({3, 3, 3}, kVoxel, 1.2));
    const Profile flat{{{0, 0}, {kRadius, 0}, {kRadius, 1}, {0, 1}}};
    scene.tool = make_tool(flat, static_cast<int>(std::lround(2 * kRadius / (spacing_voxels * kVoxel))) + 1);
    const double w = normal(random), x = normal(random), y = normal(random), z = normal(random);
    const Quat turned = Quat(w, x, y, z).normalized();
    const Vec3 middle(0, 0, -1.5), way = turned * Vec3(0, 0, -kHalfWay);
    const int frames = static_cast<int>(std::ceil(2 * kHalfWay / (0.5 * kVoxel)));
    scene.motion = straight(middle - way, middle + way, frames, kRateHz, 250, turned);
    const Leftovers found = ream_and_look(scene, 0.5, 0.5);
    swept += found.swept;
    left += found.left;
  }
  std::cout << "seed " << kSeed << ", spacing " << spacing_voxels << " voxels: " << left << " of " << swept
            << " left\n";
  return static_cast<double>(left) / static_cast<double>(swept);
}

TEST(LeakOfAShell, IsAboutWhatIsWarnedOf) {
  for (const double spacing : {0.6, 0.7}) EXPECT_EQ(measured_leak(spacing), 0) << spacing;
  for (const double spacing : {1.0, 1.5}) {
    const double factor = measured_leak(spacing) / expected_leak(spacing);
    EXPECT_GT(factor, 0.4) << spacing;
    EXPECT_LT(factor, 2.5) << spacing;
  }
}

}  // namespace
}  // namespace reamsim::test::leak_tests
