// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What `check` says that exact erosion will take, against what it takes.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "sim/base/error.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/common/engine.h"
#include "sim/run/cost_estimate.h"
#include "sim/scene/contact_forecast.h"
#include "tests/engine/frame_rows.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::forecast_tests {
namespace {

/// A cap that comes down askew into a block of whole bone, 4 mm deep.
SimulationInput plunge() {
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.bone.set_voxels(block({40, 40, 20}, 0.2, 1.8));
  scene.tool = make_tool(cap_profile(20, 16, 12, 1), 64);
  const Quat tilt(Eigen::AngleAxisd(0.2, Vec3(1, 2, 0).normalized()));
  scene.motion = straight({0, 1, 3}, {0.5, 1, -4}, 200, 1000, 250, tilt);
  return scene;
}

struct Taken {
  std::size_t pages = 0;
  std::size_t device_bytes = 0;
};

Taken taken_by(SimulationInput scene) {
  const TempDir dir;
  Recorder recorder(dir.path(), scene.bone.voxmap->grid.voxel_mm);
  Diagnostics report;
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  simulate(scene, *engine, recorder, {}, report);
  recorder.close();
  return {scene.bone.fill.stored_bricks(), engine->device_bytes()};
}

TEST(Forecast, BoundsWhatIsCut) {
  const SimulationInput scene = plunge();
  const ExactForecast forecast = forecast_exact(scene);
  const Taken taken = taken_by(scene);
  EXPECT_GE(forecast.partial, taken.pages);
  // A brick's side and more counts round the tool: 1.6 mm and two voxels round a cap of 16 mm that goes 4 mm deep.
  EXPECT_LE(forecast.partial, 2.5 * static_cast<double>(taken.pages));
  EXPECT_GE(exact_engine_bytes(scene.bone, scene.tool, forecast), taken.device_bytes);
  EXPECT_LE(exact_engine_bytes(scene.bone, scene.tool, forecast), 3 * taken.device_bytes);
}

TEST(Forecast, OfOneJumpAndOfManySteps) {
  SimulationInput scene = plunge();
  const ExactForecast slow = forecast_exact(scene);
  scene.motion.poses = {scene.motion.poses.front(), scene.motion.poses.back()};
  EXPECT_NEAR(static_cast<double>(forecast_exact(scene).partial), static_cast<double>(slow.partial),
              0.1 * static_cast<double>(slow.partial));
}

TEST(Forecast, CountsBricksThatAreNotWholeAlready) {
  SimulationInput scene = plunge();
  std::vector<ToolPose> poses = scene.motion.poses.all();
  for (ToolPose& pose : poses) pose.position_mm.z() += 100;  // never comes near
  scene.motion.poses = poses;
  EXPECT_EQ(forecast_exact(scene).partial, 0U);
  scene.bone.fill.set({3, 3, 3}, 1000);
  scene.bone.fill.set({100, 3, 3}, 1000);
  EXPECT_EQ(forecast_exact(scene).partial, 2U);
  EXPECT_EQ(forecast_exact(scene).listed, 0U);
}

/// The cap of plunge(), upright.
SimulationInput upright(const Vec3& from, const Vec3& to) {
  SimulationInput scene = plunge();
  scene.motion = straight(from, to, 200, 1000, 250, Quat::Identity());
  return scene;
}

ContactForecast forecast_contact(const SimulationInput& scene) {
  return forecast_passes(scene).front();
}

TEST(ContactForecast, HowCloseTheToolComes) {
  const ContactForecast above = forecast_contact(upright({0, 1, 9}, {0, 1, 6}));
  EXPECT_FALSE(above.touches);
  EXPECT_NEAR(above.nearest_mm, 6, 0.1);
  EXPECT_GE(above.frame, 195);
  EXPECT_LT((above.bone_mm - Vec3(0, 1, -0.1)).norm(), 3) << "under the rim of the bore";
  EXPECT_EQ(above.start_mm3, 0);
  // It flies past: 3 mm over the block in the middle of its way, far from it at both ends.
  const ContactForecast past = forecast_contact(upright({-90, 0, 3}, {90, 0, 3}));
  EXPECT_FALSE(past.touches);
  EXPECT_NEAR(past.nearest_mm, 3, 0.1);
  EXPECT_NEAR(static_cast<double>(past.frame), 100, 32);
  // And as far past its edge: the tool has a radius of 8 mm.
  const ContactForecast beside = forecast_contact(upright({20 + 8 + 5, 0, 4}, {20 + 8 + 5, 0, -14}));
  EXPECT_FALSE(beside.touches);
  EXPECT_NEAR(beside.nearest_mm, 5, 0.1);
}

TEST(ContactForecast, MeetsWhatItTouches) {
  EXPECT_TRUE(forecast_contact(upright({0, 1, 9}, {0, 1, -0.05})).touches);
  EXPECT_TRUE(forecast_contact(upright({-90, 0, -0.3}, {90, 0, -0.3})).touches) << "only on the way";
  EXPECT_TRUE(forecast_contact(plunge()).touches);
}

TEST(ContactForecast, IsNeverWrongWhereARunCuts) {
  // Down and back up, with the turning point between the steps of the search. The rim of the bore lies 0.025 mm above
  // the tool's origin.
  for (const double lowest_mm : {0.12, 0.02, -0.03, -0.045, -0.07}) {
    SimulationInput scene = upright({0, 1, 0.5}, {0, 1, lowest_mm});
    std::vector<ToolPose> poses = scene.motion.poses.all();
    for (std::size_t i = poses.size(); i-- > 0;) poses.push_back(poses[i]);
    scene.motion.poses = poses;
    const bool touches = forecast_contact(scene).touches;
    const test::FrameRows rows = test::run_rows(scene);
    EXPECT_TRUE(touches || std::ranges::none_of(rows.rows, &FrameResult::in_contact)) << lowest_mm;
    if (lowest_mm < -0.026) {
      EXPECT_TRUE(std::ranges::any_of(rows.rows, &FrameResult::in_contact)) << lowest_mm;
    }
  }
  // Over a rounded tool, more than the diagonal of a voxel of 0.2 mm is clear of the bone.
  EXPECT_FALSE(forecast_contact(upright({0, 1, 9}, {0, 1, 0.4})).touches);
}

/// The first and the last frame that removes bone: more than the units of fill by which windows of smooth motion and
/// single frames can differ on a surface that slides along itself.
FrameSpan removing_frames(SimulationInput scene) {
  const TempDir dir;
  Recorder recorder(dir.path(), scene.bone.voxmap->grid.voxel_mm);
  Diagnostics report;
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  simulate(scene, *engine, recorder, {}, report);
  recorder.close();
  std::ifstream csv(dir.path() + "/forces.csv");
  std::string line;
  std::getline(csv, line);
  std::optional<FrameSpan> out;
  for (std::int64_t frame = 0; std::getline(csv, line); ++frame) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (std::stod(cells.at(21)) <= 1e-3 * scene.bone.voxmap->grid.voxel_mm3()) continue;
    out = FrameSpan{out ? out->first : frame, frame};
  }
  return out.value_or(FrameSpan{-1, -1});
}

TEST(ContactForecast, TellsFromWhenToWhenBoneIsRemoved) {
  // Down for 2 s with 3 mm/s, the last 4 mm of them in the bone; at rest for 0.5 s; and back.
  const auto there_and_back = [](const Quat& orientation) {
    SimulationInput scene = plunge();
    scene.motion = straight({0, 1, 2}, {0, 1, -4}, 2000, 1000, 250, orientation);
    std::vector<ToolPose> poses = scene.motion.poses.all();
    const std::vector<ToolPose> down = poses;
    poses.insert(poses.end(), 500, down.back());
    for (std::size_t i = down.size(); i-- > 0;) poses.push_back(down[i]);
    scene.motion.poses = poses;
    return scene;
  };
  for (const Quat& orientation : {Quat::Identity(), Quat(Eigen::AngleAxisd(0.2, Vec3(1, 2, 0).normalized()))}) {
    const SimulationInput scene = there_and_back(orientation);
    const std::optional<FrameSpan> expected = forecast_contact(scene).frames;
    ASSERT_TRUE(expected);
    const FrameSpan found = removing_frames(scene);
    // A tenth of a voxel is 7 frames; the bone's voxels have 0.2 mm.
    EXPECT_NEAR(static_cast<double>(expected->first), static_cast<double>(found.first), 20);
    EXPECT_NEAR(static_cast<double>(expected->last), static_cast<double>(found.last), 20);
  }
  EXPECT_FALSE(forecast_contact(upright({0, 1, 9}, {0, 1, 6})).frames);
  EXPECT_EQ(forecast_contact(upright({0, 0, -4}, {0, 0, -5})).frames->first, 0) << "it starts in the bone";
}

TEST(ContactForecast, EndsWithTheLastBoneOfASweep) {
  // Across the block, from beside it to beside it.
  const SimulationInput scene = upright({-30, 0, -1}, {30, 0, -1});
  const std::optional<FrameSpan> expected = forecast_contact(scene).frames;
  ASSERT_TRUE(expected);
  const FrameSpan found = removing_frames(scene);
  const double brick_frames = 8 * 0.2 / (60.0 / 200);
  EXPECT_NEAR(static_cast<double>(expected->first), static_cast<double>(found.first), 2);
  EXPECT_NEAR(static_cast<double>(expected->last), static_cast<double>(found.last), brick_frames);
}

TEST(ContactForecast, WhatAStartInTheBoneTakesAway) {
  SimulationInput scene = upright({0, 0, -4}, {0, 0, -5});
  // A sphere's cap of 20 mm radius out to 8 mm, 4 mm deep, without its bore of 1 mm radius.
  const auto under_sphere = [](double r) { return 10 * r * r + std::pow(400 - r * r, 1.5) / 3; };
  const double cap_mm3 = std::numbers::pi * (4 * (64 - 1) - 2 * (under_sphere(8) - under_sphere(1)));
  const ContactForecast forecast = forecast_contact(scene);
  EXPECT_NEAR(forecast.start_mm3 / cap_mm3, 1, 0.01);
  scene.bone.set_voxels(FilledVoxmap(scene.bone.voxmap->grid));
  EXPECT_EQ(forecast_contact(scene).start_mm3, 0) << "no bone";
  EXPECT_FALSE(forecast_contact(scene).touches);
}

TEST(FillPages, AreNoMoreThanBricks) {
  const SimulationInput scene = plunge();
  const cl::Device device(cl::choose_device("auto"));
  FillPages fill = make_fill_pages(device, scene.bone);
  const std::size_t bricks = scene.bone.voxmap->grade.stored_bricks();
  reserve_pages(device, bricks - 1, 0.2, fill);
  EXPECT_EQ(fill.room(), bricks);
  reserve_pages(device, 10 * bricks, 0.2, fill);
  EXPECT_EQ(fill.room(), bricks);
}

TEST(FillPages, WhatDoesNotFitSaysWhatWould) {
  const SimulationInput scene = plunge();
  cl::DeviceInfo info = cl::choose_device("auto");
  info.max_allocation_bytes = 1024 * 1000;  // 1000 pages
  const cl::Device device(info);
  FillPages fill = make_fill_pages(device, scene.bone);
  reserve_pages(device, 900, 0.2, fill);
  EXPECT_EQ(fill.room(), 1000U);
  try {
    reserve_pages(device, 2000, 0.2, fill);
    FAIL() << "it fits";
  } catch (const RunError& error) {
    // 2^(1/3)·1.05·0.2 mm
    EXPECT_THAT(error.what(),
                testing::AllOf(testing::HasSubstr("needs 3 MB"), testing::HasSubstr("supports at most 2 MB"),
                               testing::HasSubstr("bone.voxel_mm of 0.265 or more would fit")));
  }
}

TEST(DeviceMemory, WhatDoesNotFitIsAMistakeInTheInput) {
  cl::DeviceInfo info = cl::choose_device("auto");
  info.max_allocation_bytes = 1'000'000;
  const cl::Device device(info);
  const auto mistake = [&](const char* key) {
    try {
      cl::allocate_memory(device, 2'000'000, "the list", key);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(mistake("bone.voxel_mm"),
              testing::AllOf(testing::StartsWith("bone.voxel_mm: the list needs 2 MB in one allocation; "),
                             testing::HasSubstr(" supports at most 1 MB; use larger voxels")));
  EXPECT_THAT(mistake("tool.shell_resolution"), testing::EndsWith("use a smaller value"));
}

}  // namespace
}  // namespace reamsim::test::forecast_tests
