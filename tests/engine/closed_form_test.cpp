// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Analytic truth: a cannulated convex reamer plunged into a uniform half-space (docs/physics.md, 6).
#include <gtest/gtest.h>

#include <fstream>
#include <iostream>
#include <sstream>

#include "tests/engine/scene_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test::closed_form_tests {
namespace {

constexpr double kRadius = 29, kWidth = 30, kBore = 1.25, kRpm = 250, kFeed = 0.2, kDensity = 1.8, kVoxel = 0.25;
constexpr double kFullContact = 4.18;  // mm, 29 − √(29² − 15²)

struct Row {
  double depth, force_z, torque_z, removed;
};

std::vector<Row> rows(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  std::vector<Row> out;
  while (std::getline(in, line)) {
    std::stringstream fields(line);
    std::vector<double> v;
    for (std::string f; std::getline(fields, f, ',');) v.push_back(std::stod(f));
    out.push_back({v[11], v[14], v[17], v[21]});
  }
  return out;
}

struct Plunge {
  std::vector<Row> rows;
  RunTotals totals{1};
  double rate_hz = 0;
};

/// Plunges `depth` mm into the half-space. The frame rate only says how often the steady feed is sampled.
Plunge plunge(const std::string& device, double depth, double rate_hz, double voxel) {
  SimulationInput scene;
  scene.scenario = quiet_scenario(device);
  scene.bone.set_voxels(block({33, 33, 6}, voxel, kDensity));
  scene.tool = make_tool(cap_profile(kRadius, kWidth, 8, kBore), static_cast<int>(std::ceil(30 / (voxel / 2))) + 1);
  const int frames = static_cast<int>(std::lround((depth + 0.1) / kFeed * rate_hz));
  scene.motion = straight({0.03, 0.05, 0.1}, {0.03, 0.05, -depth}, frames, rate_hz, kRpm);
  const TempDir dir;
  Plunge out;
  out.rate_hz = rate_hz;
  Diagnostics report;
  Recorder recorder(dir.path(), scene.bone.voxmap->grid.voxel_mm);
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  simulate(scene, *engine, recorder, {}, report);
  recorder.close();
  out.totals = recorder.totals();
  out.rows = rows(dir.path() + "/forces.csv");
  return out;
}

double c_of(double r) {
  return 0.5 * (r * std::sqrt(1 - r * r / (kRadius * kRadius)) + kRadius * std::asin(r / kRadius));
}

TEST(ClosedForm, SteadyPlungeOfACannulatedConvexReamer) {
  const Plunge p = plunge("auto", 5.4, 200, kVoxel);
  const double a = kWidth / 2, omega = kRpm * 2 * M_PI / 60, u = 150;  // N/mm² at 1.8 g/cm³
  const double torque = M_PI * u * (a * a - kBore * kBore) * kFeed / omega;
  const double thrust = 2 * M_PI * 0.5 * u * (kFeed / omega) * (c_of(a) - c_of(kBore)) +
                        2 * M_PI * u * (kFeed / omega) * (kFeed / omega) * std::log(a / kBore);
  EXPECT_NEAR(torque, 804.4, 0.1);  // docs/physics.md, 6
  EXPECT_NEAR(thrust, 47.1, 0.1);

  // The last whole voxel layer of full contact.
  const auto layer = static_cast<std::size_t>(std::lround(kVoxel / kFeed * p.rate_hz));
  double mean_torque = 0, mean_thrust = 0, removed = 0;
  for (std::size_t i = p.rows.size() - layer; i < p.rows.size(); ++i) {
    ASSERT_GT(p.rows[i].depth, kFullContact + kVoxel);
    mean_torque += p.rows[i].torque_z / double(layer);
    mean_thrust += p.rows[i].force_z / double(layer);
    removed += p.rows[i].removed;
  }
  const double volume = M_PI * (a * a - kBore * kBore) * kVoxel;
  std::cout << "torque " << mean_torque << " of " << torque << ", thrust " << mean_thrust << " of " << thrust
            << ", removed per layer " << removed << " of " << volume << '\n';
  EXPECT_NEAR(mean_torque / torque, 1, 0.03);
  EXPECT_NEAR(mean_thrust / thrust, 1, 0.03);
  EXPECT_NEAR(removed / volume, 1, 0.03);
  EXPECT_LT(std::abs(p.totals.balance), 1e-4);
}

TEST(ClosedForm, CapVolumeAgainstSerialAndAnalytic) {
  const double depth = 3, coarse = 0.5;
  const Plunge device = plunge("auto", depth, 50, coarse), serial = plunge("serial", depth, 50, coarse);
  EXPECT_EQ(device.totals.removed_mm3, serial.totals.removed_mm3);
  // A spherical cap less the core, r < bore, that stays.
  const double cap = M_PI * depth * depth * (kRadius - depth / 3);
  const double sag = kRadius - std::sqrt(kRadius * kRadius - kBore * kBore);
  const double core = M_PI * kBore * kBore * (depth - sag / 2);
  const double excess = device.totals.removed_mm3 / (cap - core) - 1;
  std::cout << "removed " << device.totals.removed_mm3 << " mm3, cap less core " << cap - core << " mm3, excess "
            << 100 * excess << " %\n";
  // Touched voxels go whole, so about half a voxel too much everywhere: never too little.
  EXPECT_GT(excess, 0);
  EXPECT_LT(excess, 0.35);
}

TEST(ClosedForm, WithdrawalTakesNothing) {
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  scene.bone.set_voxels(block({12, 12, 4}, 0.25, 1.2));
  scene.tool = make_tool(cap_profile(8, 8, 4, 0.5), 80);
  const Motion down = straight({0, 0, 0.2}, {0, 0, -1}, 100, 500, 250),
               up = straight({0, 0, -1}, {0, 0, 1}, 100, 500, 250);
  scene.motion = down;
  std::vector<ToolPose> poses = down.poses.all();
  for (std::size_t k = 1; k < up.poses.size(); ++k) poses.push_back(up.poses[k]);
  scene.motion.poses = poses;
  const TempDir dir;
  Diagnostics report;
  Recorder recorder(dir.path(), scene.bone.voxmap->grid.voxel_mm);
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  simulate(scene, *engine, recorder, {}, report);
  recorder.close();
  const auto all = rows(dir.path() + "/forces.csv");
  double cut_down = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i <= 100) {
      cut_down += all[i].removed;
    } else {
      EXPECT_EQ(all[i].removed, 0) << "row " << i;
      EXPECT_EQ(all[i].force_z, 0) << "row " << i;
    }
  }
  EXPECT_GT(cut_down, 10);
}

}  // namespace
}  // namespace reamsim::test::closed_form_tests
