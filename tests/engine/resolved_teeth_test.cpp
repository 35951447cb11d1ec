// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// `erosion: exact` with `spin: resolved`: teeth that are clipped by their distance grid.
#include <complex>
#include <numeric>
#include <sstream>

#include "sim/tool/profile.h"
#include "tests/engine/outcome.h"
#include "tests/support/gear_mesh.h"

namespace reamsim::test::resolved_teeth_tests {
namespace {

Tool toothed_tool(const TriangleMesh& mesh, double voxel_mm, bool by_grid = true) {
  Tool tool;
  tool.mesh = mesh;
  tool.profile = envelope_of_revolution(mesh).profile;
  tool.shell = voxelize_surface(mesh, 40);
  tool.bounds = mesh.bounds();
  for (const Vec3& v : mesh.vertices) tool.reach_mm = std::max(tool.reach_mm, v.norm());
  if (by_grid) tool.teeth = make_distance_grid(mesh, tool.profile, voxel_mm);
  return tool;
}

SimulationInput exact_scene(const std::string& device, bool resolved = true) {
  SimulationInput scene;
  scene.scenario = quiet_scenario(device);
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.scenario.tool.spin = resolved ? ToolSpin::resolved : ToolSpin::envelope;
  return scene;
}

/// A column of forces.csv.
std::vector<double> column(const std::string& forces, const std::string& name) {
  std::istringstream rows(forces);
  std::string line, cell;
  std::getline(rows, line);
  std::istringstream head(line);
  std::size_t at = 0;
  while (std::getline(head, cell, ',') && cell != name) ++at;
  std::vector<double> out;
  while (std::getline(rows, line)) {
    std::istringstream row(line);
    for (std::size_t i = 0; i <= at; ++i) std::getline(row, cell, ',');
    out.push_back(std::stod(cell));
  }
  return out;
}

/// A tilted gear that comes down askew through bone of every density.
SimulationInput oblique_gear(const std::string& device) {
  SimulationInput scene = exact_scene(device);
  scene.bone.set_voxels(random_bone({41, 37, 29}, 0.2, 7));
  scene.tool = toothed_tool(gear_mesh(4, 1.1, 2.0, 3), 0.2);
  const Quat tilt(Eigen::AngleAxisd(0.4, Vec3(1, 2, 0.5).normalized()));
  scene.motion = straight({1.5, 1, 4}, {0.6, 1.4, 0.4}, 40, 100, 250, tilt);
  return scene;
}

TEST(ResolvedTeeth, EqualTheSerialReference) {
  const Outcome serial = run(oblique_gear("serial"));
  EXPECT_GT(serial.removed.size(), 100U);
  expect_all_shapes_give(serial, oblique_gear);
  SimulationInput envelope = oblique_gear("auto");
  envelope.tool.teeth.reset();
  EXPECT_NE(run(envelope).forces, serial.forces) << "the envelope cuts otherwise";
}

/// A ball of radius 8 mm, apex at the origin, with an edge every 0.05 mm.
Profile ball_profile() {
  constexpr double kRadius = 8;
  constexpr int kSteps = 500;
  Profile profile;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = M_PI * i / kSteps;
    profile.points.emplace_back(i == 0 || i == kSteps ? 0 : kRadius * std::sin(angle), kRadius * (1 - std::cos(angle)));
  }
  return profile;
}

/// What the ball takes when it goes 2 mm into a block askew, mm3.
double cap_mm3(const Tool& tool, double voxel_mm) {
  SimulationInput scene = exact_scene("auto", tool.teeth.has_value());
  scene.bone.set_voxels(block({14, 14, 4}, voxel_mm, 1.8));
  scene.tool = tool;
  const Quat turned(Eigen::AngleAxisd(0.5, Vec3(1, 0.3, 0).normalized()));
  const Vec3 offset(0.03, 0.07, 0);
  const auto origin = [&](double depth) -> Vec3 { return offset + Vec3(0, 0, 8 - depth) - turned * Vec3(0, 0, 8); };
  scene.motion = straight(origin(-0.1), origin(2), 20, 1000, 0, turned);
  return run(scene).totals.removed_mm3;
}

TEST(ResolvedTeeth, AGridCutsWhatTheProfileCuts) {
  // The same ball, once by its profile and once by the grid of its mesh.
  const Profile profile = ball_profile();
  const TriangleMesh mesh = revolve(profile, 800);
  Tool by_profile = make_tool(profile, 40);
  std::vector<double> errors;
  for (const double voxel_mm : {0.5, 0.25}) {
    Tool by_grid = by_profile;
    by_grid.teeth = make_distance_grid(mesh, profile, voxel_mm);
    errors.push_back(cap_mm3(by_grid, voxel_mm) / cap_mm3(by_profile, voxel_mm) - 1);
    std::cout << voxel_mm << " mm: grid against profile " << 100 * errors.back() << " %\n";
  }
  EXPECT_LT(std::abs(errors[0]), 3e-3);
  EXPECT_LT(std::abs(errors[1]), 1e-3);
  EXPECT_LT(std::abs(errors[1]), 0.35 * std::abs(errors[0])) << "second order";
}

constexpr int kTeeth = 6;
constexpr double kRpm = 500, kRateHz = 1000;  // 120 frames a turn
constexpr int kTurn = static_cast<int>(kRateHz * 60 / kRpm);
constexpr double kInner = 4, kOuter = 6, kVoxel = 0.5, kFeedPerTurn = 0.25;

/// The gear goes straight down for `turns` turns into a block that begins at x = `from_x`.
SimulationInput plunge(double from_x, int turns, bool resolved, double voxel_mm = kVoxel) {
  SimulationInput scene = exact_scene("auto", resolved);
  FilledVoxmap bone = block({14, 14, 3}, voxel_mm, 1.2);
  bone.grid.origin_mm.x() = from_x;
  scene.bone.set_voxels(std::move(bone));
  const TriangleMesh mesh = gear_mesh(kTeeth, kInner, kOuter, 5);
  scene.tool = toothed_tool(mesh, voxel_mm, resolved);
  const double down = kFeedPerTurn * turns;
  scene.motion = straight({0.02, 0.03, 0}, {0.02, 0.03, -down}, turns * kTurn, kRateHz, kRpm);
  return scene;
}

/// Power of a series' lines of 1 to `lines` cycles in its length.
std::vector<double> power_spectrum(const std::vector<double>& series, int lines) {
  std::vector<double> power;
  const auto n = static_cast<double>(series.size());
  for (int cycles = 1; cycles <= lines; ++cycles) {
    std::complex<double> sum = 0;
    for (std::size_t k = 0; k < series.size(); ++k) {
      sum += series[k] * std::polar(1.0, 2 * M_PI * cycles * static_cast<double>(k) / n);
    }
    power.push_back(std::norm(sum));
  }
  return power;
}

TEST(ResolvedTeeth, TorqueHasTheToothPassingFrequency) {
  // The gear mills along the edge of a block, 1.5 mm into it, so that its teeth come into the bone one after the other.
  constexpr int kTurns = 4, kMostPerTurn = 20;
  SimulationInput scene = plunge(4.5, kTurns + 1, true);
  const double along = kFeedPerTurn * (kTurns + 1);
  scene.motion = straight({0.02, 0.03, -2.2}, {0.02, 0.03 + along, -2.2}, (kTurns + 1) * kTurn, kRateHz, kRpm);
  const Outcome outcome = run(scene);
  const std::vector<double> torque = column(outcome.forces, "spin_torque_nmm");
  const std::vector<double> power =
      power_spectrum({torque.end() - kTurns * kTurn, torque.end()}, kMostPerTurn * kTurns);
  const auto peak = std::max_element(power.begin(), power.end());
  const double hz = static_cast<double>(peak - power.begin() + 1) / (kTurns * kTurn) * kRateHz;
  EXPECT_DOUBLE_EQ(hz, kTeeth * kRpm / 60);
  const double all = std::accumulate(power.begin(), power.end(), 0.0);
  std::cout << "peak at " << hz << " Hz with " << 100 * *peak / all << " % of the power\n";
  EXPECT_GT(*peak, 0.3 * all);
  EXPECT_LT(std::abs(outcome.totals.balance), 1e-6);
}

TEST(ResolvedTeeth, ATurnTakesWhatTheEnvelopeTakes) {
  const auto last_turn = [](const Outcome& outcome) {
    const std::vector<double> removed = column(outcome.forces, "removed_mm3");
    return std::accumulate(removed.end() - kTurn, removed.end(), 0.0);
  };
  const double closed_form = M_PI * kOuter * kOuter * kFeedPerTurn;
  // One plane in a voxel rounds the teeth's sharp rim off, which the envelope has two planes for.
  const Outcome coarse = run(plunge(-7, 5, true)), fine = run(plunge(-7, 5, true, kVoxel / 2));
  const Outcome envelope = run(plunge(-7, 5, false));
  std::cout << "mm3 in a turn: teeth " << last_turn(coarse) << ", at half the voxel " << last_turn(fine)
            << ", envelope " << last_turn(envelope) << ", closed form " << closed_form << '\n';
  EXPECT_NEAR(last_turn(envelope), closed_form, 1e-3 * closed_form);
  EXPECT_NEAR(last_turn(coarse), closed_form, 0.05 * closed_form);
  EXPECT_NEAR(last_turn(fine), closed_form, 0.0125 * closed_form);
  EXPECT_LT(std::abs(coarse.totals.balance), 1e-6);
}

TEST(ResolvedTeeth, TheSamePathAgainTakesNothing) {
  SimulationInput scene = plunge(-7, 2, true);
  const std::vector<ToolPose> down = scene.motion.poses.all();
  std::vector<ToolPose> poses = down;
  poses.insert(poses.end(), down.rbegin(), down.rend());
  poses.insert(poses.end(), down.begin(), down.end());
  scene.motion.poses = poses;
  const Outcome outcome = run(scene);
  const std::vector<double> contacts = column(outcome.forces, "contacts");
  EXPECT_GT(std::accumulate(contacts.begin(), contacts.end(), 0.0), 1000);
  EXPECT_EQ(std::accumulate(contacts.begin() + std::ssize(down), contacts.end(), 0.0), 0);
}

}  // namespace
}  // namespace reamsim::test::resolved_teeth_tests
