// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// `erosion: exact` against closed forms and against its serial reference.
#include <iostream>
#include <sstream>

#include "kernels/clip.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::exact_tests {
namespace {

/// The same fraction by slicing the cube and integrating the part of each slice in closed form would hide the same
/// mistakes: count the points of a lattice instead.
double counted_fraction(const Vec3& n, double distance, int per_axis) {
  std::int64_t outside = 0;
  for (int i = 0; i < per_axis; ++i)
    for (int j = 0; j < per_axis; ++j)
      for (int k = 0; k < per_axis; ++k) {
        const Vec3 x = (Vec3(i, j, k) + Vec3::Constant(0.5)) / per_axis - Vec3::Constant(0.5);
        outside += x.dot(n) + distance > 0 ? 1 : 0;
      }
  return static_cast<double>(outside) / std::pow(per_axis, 3);
}

TEST(Clip, AgreesWithCountingPoints) {
  constexpr unsigned kSeed = 4711;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 300; ++i) {
    Vec3 n(gauss(random), gauss(random), gauss(random));
    if (i % 3 == 1) n[i / 3 % 3] *= 1e-4;  // all but parallel to a face
    if (i % 5 == 1) n[(i / 5 + 1) % 3] = 0;
    n.normalize();
    const double distance = u(random);
    const float nf[3] = {static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z())};
    EXPECT_NEAR(rs_outside_fraction(nf, static_cast<float>(distance)), counted_fraction(n, distance, 60), 0.012)
        << n.transpose() << ", " << distance;
  }
}

TEST(Clip, SharesOfAStackOfVoxelsAddUpToTheDistance) {
  // Along any axis the fractions of a column of cubes add up to where the plane meets the column's middle, whatever the
  // tilt: no volume is made or lost.
  constexpr unsigned kSeed = 12;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> u(-0.5, 0.5);
  for (int i = 0; i < 2000; ++i) {
    Vec3 n(gauss(random), gauss(random), gauss(random));
    if (i % 4 == 0) n.head<2>() *= std::pow(10, -1 - i % 7);
    n.normalize();
    if (std::abs(n.z()) < 0.05) continue;
    const float nf[3] = {static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z())};
    const double middle = u(random);
    double sum = 0;
    for (int k = -40; k <= 40; ++k) sum += rs_outside_fraction(nf, static_cast<float>((k - middle) * n.z()));
    // Half of the 81 cubes' length, and the way of the plane along n from there.
    EXPECT_NEAR(sum, 40.5 - (n.z() > 0 ? middle : -middle), 2e-5) << n.transpose() << ", " << middle;
  }
}

SimulationInput exact(SimulationInput scene) {
  scene.scenario.cutting.erosion = ErosionMode::exact;
  return scene;
}

TEST(Exact, EqualsTheSerialReference) {
  const Outcome serial = run(exact(oblique_scene("serial")));
  EXPECT_GT(serial.removed.size(), 100U);
  expect_all_shapes_give(serial, [](const std::string& device) { return exact(oblique_scene(device)); });
}

TEST(Exact, EqualsTheSerialReferenceFarFromTheOriginOfTheLattice) {
  // The end of a bar of 128 superbricks along each axis: their places are multiples of their index.
  constexpr double kLength_mm = 819.2, kWidth_mm = 6.4, kVoxel_mm = 0.2;
  for (int axis = 0; axis < 3; ++axis) {
    const auto scene = [&](const std::string& device) {
      SimulationInput out;
      out.scenario = quiet_scenario(device);
      Vec3 size_mm = Vec3::Constant(kWidth_mm), end = Vec3::Zero();
      size_mm[axis] = kLength_mm;
      if (axis < 2) end[axis] = kLength_mm / 2 - 1;
      out.bone.set_voxels(block(size_mm, kVoxel_mm, 1.2));
      out.tool = make_tool(cap_profile(5, 6, 3, 0.6), 64);
      out.motion = straight(end + Vec3(0, 0, 0.3), end - Vec3(0, 0, 0.5), 20, 1000, 250);
      return exact(out);
    };
    const Outcome serial = run(scene("serial"));
    EXPECT_GT(serial.removed.size(), 100U) << "axis " << axis;
    expect_same(run(scene("auto")), serial);
  }
}

/// Bone of all densities, with sharp corners, size effect and edge force: 200 frames of feed and tilt, most of them in
/// windows of smooth motion, and a stroke through several substeps before the last.
SimulationInput slow_scene(const std::string& device) {
  SimulationInput scene = exact(oblique_scene(device));
  scene.scenario.cutting.size_effect.emplace();
  scene.scenario.cutting.edge_force.emplace();
  const ToolPose begin = scene.motion.poses[20];
  ToolPose end = begin;
  end.position_mm += Vec3(0.02, 0.01, -0.3);
  end.orientation = Quat(Eigen::AngleAxisd(0.01, Vec3(1, 0.3, 0).normalized())) * begin.orientation;
  end.spin_angle_rad += 5;
  scene.motion.frame_rate_hz = 1000;
  std::vector<ToolPose> poses;
  for (int k = 0; k <= 200; ++k) poses.push_back(interpolate(begin, end, k / 200.0));
  for (int k = 150; k <= 200; ++k) poses[static_cast<std::size_t>(k)].position_mm.z() -= 0.4;
  scene.motion.poses = poses;
  return scene;
}

TEST(Exact, WindowsEqualTheSerialReference) {
  const Outcome serial = run(slow_scene("serial"));
  EXPECT_GT(serial.removed.size(), 100U);
  SimulationInput framed = slow_scene("auto");
  framed.scenario.engine.tuning.windows = false;
  EXPECT_NE(run(framed).forces, serial.forces) << "windows are in use";
  expect_all_shapes_give(serial, slow_scene);
}

/// A ball, radius 29 mm, with an edge every `step_mm`.
Tool ball(double step_mm, int shell = 64) {
  constexpr double kRadius = 29;
  Profile profile;
  const int steps = static_cast<int>(std::ceil(kRadius * M_PI / step_mm));
  for (int i = 0; i <= steps; ++i) {
    const double angle = M_PI * i / steps;
    profile.points.emplace_back(i == 0 || i == steps ? 0 : kRadius * std::sin(angle), kRadius * (1 - std::cos(angle)));
  }
  return make_tool(profile, shell);
}

/// The ball plunged 4 mm into a block, its middle off the lattice and its axis tilted.
SimulationInput plunged_ball(const Tool& tool, double voxel_mm, const Vec3& offset_mm, const Quat& turned,
                             const std::string& device = "auto") {
  SimulationInput scene = exact({});
  scene.scenario = quiet_scenario(device);
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.bone.set_voxels(block({34, 34, 8}, voxel_mm, 1.8));
  scene.tool = tool;
  const auto origin = [&](double depth) -> Vec3 {
    return offset_mm + Vec3(0, 0, 29 - depth) - turned * Vec3(0, 0, 29);
  };
  scene.motion = straight(origin(-0.1), origin(4), 40, 1000, 250, turned);
  return scene;
}

/// RMS error of the plunged cap's volume over random offsets and tilts up to 60°, as a share.
double cap_error(const Tool& tool, double voxel_mm, ErosionMode erosion) {
  constexpr unsigned kSeed = 31;
  std::cout << "seed " << kSeed << ": ";
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-0.5, 0.5);
  const double expected = M_PI * 16 * (3 * 29 - 4) / 3;
  constexpr int kTimes = 4;
  double sum = 0;
  for (int i = 0; i < kTimes; ++i) {
    const Quat turned(Eigen::AngleAxisd(M_PI / 3 * i / (kTimes - 1), Vec3(std::cos(i), std::sin(i), 0)));
    SimulationInput scene = plunged_ball(tool, voxel_mm, voxel_mm * Vec3(u(random), u(random), 0), turned);
    scene.scenario.cutting.erosion = erosion;
    const double error = run(scene).totals.removed_mm3 / expected - 1;
    sum += error * error;
  }
  const double rms = std::sqrt(sum / kTimes);
  std::cout << name_of(erosion) << ", " << voxel_mm << " mm: RMS error " << 100 * rms << " %\n";
  return rms;
}

TEST(Exact, CapVolume) {
  // What is left is the polygon's: edges of 0.1 mm lie 0.03 µm within the sphere in the mean, 0.0015 % of the cap.
  const Tool tool = ball(0.1);
  EXPECT_LT(cap_error(tool, 1.0, ErosionMode::exact), 1e-4);
  EXPECT_LT(cap_error(tool, 0.5, ErosionMode::exact), 5e-5);
  const double exact = cap_error(tool, 0.25, ErosionMode::exact);
  EXPECT_LT(exact, 5e-5);
  EXPECT_GT(cap_error(ball(0.1, 490), 0.25, ErosionMode::remove), 50 * exact);
}

/// Mean and standard deviation of a column of forces.csv, over the last `rows` rows.
std::pair<double, double> statistics_of(const std::string& forces, std::size_t column, std::size_t rows) {
  std::vector<double> values;
  std::istringstream lines(forces);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::istringstream row(line);
    std::string cell;
    for (std::size_t i = 0; i <= column; ++i) std::getline(row, cell, ',');
    values.push_back(std::stod(cell));
  }
  values.erase(values.begin(), values.end() - static_cast<std::ptrdiff_t>(rows));
  double mean = 0, square = 0;
  for (const double v : values) mean += v / static_cast<double>(rows);
  for (const double v : values) square += (v - mean) * (v - mean) / static_cast<double>(rows);
  return {mean, std::sqrt(square)};
}

TEST(Exact, ARimAlongTheLatticeTakesTheSameFromEveryLayer) {
  // All round the rim the layers of voxels are cut at the same phase, so that what one plane per voxel would make of
  // the corner shows as a ripple. Torque, too, has its closed form (docs/physics.md, 6).
  constexpr double kOuter = 10, kBore = 1.25, kFeed_mm = 0.01, kRate_hz = 20, kRpm = 250, kSpin = kRpm * M_PI / 30;
  constexpr std::size_t kSteady = 150;  // frames: six layers
  const Profile flat{{{kBore, 0}, {kOuter, 0}, {kOuter, 5}, {kBore, 5}}};
  for (const Profile& profile : {flat, cap_profile(29, 2 * kOuter, 6, kBore)}) {
    // Down to a depth of 1.9 mm at the rim, a hundredth of a millimetre a frame.
    const double rim = profile.points.size() > 4 ? 29 - std::sqrt(29 * 29 - kOuter * kOuter) : 0;
    const int frames = static_cast<int>(std::round((rim + 2) / kFeed_mm));
    SimulationInput scene = exact({});
    scene.scenario = quiet_scenario("auto");
    scene.scenario.cutting.erosion = ErosionMode::exact;
    scene.bone.set_voxels(block({24, 24, 5}, 0.25, 1.8));
    scene.tool = make_tool(profile, 64);
    scene.motion = straight({0.13, 0.07, 0.1}, {0.13, 0.07, 0.1 - frames * kFeed_mm}, frames, kRate_hz, kRpm);
    const Outcome outcome = run(scene);
    const double area = M_PI * (kOuter * kOuter - kBore * kBore);
    const auto [volume, volume_ripple] = statistics_of(outcome.forces, 21, kSteady);
    const auto [torque, torque_ripple] = statistics_of(outcome.forces, 19, kSteady);
    std::cout << "volume " << volume / (area * kFeed_mm) - 1 << " off, ripple " << volume_ripple / volume
              << "; ripple of the torque " << torque_ripple / torque << '\n';
    EXPECT_NEAR(volume, area * kFeed_mm, 1e-3 * area * kFeed_mm);
    EXPECT_LT(volume_ripple / volume, 2e-3);
    EXPECT_NEAR(std::abs(torque), 150 * area * kFeed_mm * kRate_hz / kSpin, 5e-3 * std::abs(torque));
    EXPECT_LT(std::abs(torque_ripple / torque), 2e-3);
  }
}

TEST(Exact, RestingTurningAndComingBackTakeNothing) {
  const Tool tool = ball(0.3);
  SimulationInput scene = plunged_ball(tool, 0.5, Vec3(0.11, 0.23, 0), Quat(Eigen::AngleAxisd(0.3, Vec3::UnitX())));
  const std::vector<ToolPose> down = scene.motion.poses.all();
  std::vector<ToolPose> poses = down;
  for (int k = 0; k < 50; ++k) poses.push_back(down.back());  // rests, and spins
  poses.insert(poses.end(), down.rbegin(), down.rend());      // goes back
  poses.insert(poses.end(), down.begin(), down.end());        // and comes again
  for (std::size_t k = 0; k < poses.size(); ++k) poses[k].spin_angle_rad = 0.026 * static_cast<double>(k);
  scene.motion.poses = poses;
  const Outcome outcome = run(scene);
  std::istringstream rows(outcome.forces);
  std::string line;
  std::getline(rows, line);
  for (std::size_t k = 0; std::getline(rows, line); ++k) {
    if (k < down.size()) continue;
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    ASSERT_EQ(cells[20], "0") << "contacts in row " << k << ": " << line;
    ASSERT_EQ(cells[18], "0") << "force in row " << k << ": " << line;
  }
}

TEST(Exact, BoneThatTheToolStartsInGoesWithoutForce) {
  const Tool tool = ball(0.1);
  SimulationInput scene = plunged_ball(tool, 0.5, Vec3(0.2, 0.1, 0), Quat::Identity());
  scene.motion.poses = std::vector<ToolPose>(3, scene.motion.poses.back());
  const Outcome outcome = run(scene);
  EXPECT_NEAR(outcome.totals.removed_mm3, M_PI * 16 * (3 * 29 - 4) / 3, 0.2);
  EXPECT_EQ(outcome.totals.energy_mj, 0);
  ASSERT_FALSE(outcome.report.warnings.empty());
  EXPECT_NE(outcome.report.warnings[0].find("starts in the bone"), std::string::npos);
}

}  // namespace
}  // namespace reamsim::test::exact_tests
