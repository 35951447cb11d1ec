// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The force basis of a run gives the forces of a run with other constants.
#include <iostream>

#include "sim/record/recorder.h"
#include "sim/scenario/parse.h"
#include "sim/tool/distance_grid.h"
#include "sim/tool/profile.h"
#include "tests/study/basis_scene.h"
#include "tests/support/gear_mesh.h"

namespace reamsim::test::force_basis_tests {
namespace {

/// The bar of a rerun with other constants, relative to the peak.
constexpr double kSame = 1e-5;

CuttingSettings preset(CuttingSettings cutting, EnergyPreset name) {
  cutting.preset = name;
  apply_preset(KeyLocations(), cutting);
  return cutting;
}

CuttingSettings table(CuttingSettings cutting) {
  cutting.specific_energy_table = {{0.1, 0.002}, {0.7, 0.05}, {1.3, 0.04}, {1.9, 0.2}};
  return cutting;
}

CuttingSettings normal_ratio(CuttingSettings cutting, double k_n) {
  cutting.normal_ratio = k_n;
  return cutting;
}

/// Compares the basis of the scene with reruns; `of`: for messages.
void expect_forces_of_reruns(const SimulationInput& scene, const std::string& of) {
  SCOPED_TRACE(of);
  const RowSink run = rows_of(scene, true), plain = rows_of(scene, false);
  ASSERT_EQ(run.results.size(), plain.results.size());
  for (std::size_t i = 0; i < run.results.size(); ++i) {
    EXPECT_EQ(run.results[i].force_n, plain.results[i].force_n);
    EXPECT_EQ(run.results[i].balance, plain.results[i].balance);
  }
  const ForceBasis basis(run.basis_rows);
  const CuttingSettings& own = scene.scenario.cutting;
  const std::vector<std::pair<std::string, CuttingSettings>> cases{
      {"own", own},
      {"assumed-low", preset(own, EnergyPreset::assumed_low)},
      {"assumed-mid", preset(own, EnergyPreset::assumed_mid)},
      {"assumed-high", preset(own, EnergyPreset::assumed_high)},
      {"table", table(own)},
      {"k_n 0", normal_ratio(own, 0)},
      {"k_n 1.3", normal_ratio(table(own), 1.3)}};
  for (const auto& [name, cutting] : cases) {
    SCOPED_TRACE(name);
    SimulationInput again = scene;
    again.scenario.cutting = cutting;
    const BasisError error = error_of(basis, cutting, rows_of(again, false).results);
    std::cout << of << ", " << name << ": force " << error.force << ", torque " << error.torque << ", energy "
              << error.energy << ", floor " << error.floor_energy << ", balance " << error.work << '\n';
    EXPECT_LT(error.force, kSame);
    EXPECT_LT(error.torque, kSame);
    EXPECT_LT(error.energy, kSame);
    EXPECT_LT(error.floor_energy, kSame);
    EXPECT_LT(error.work, 1e-6);
  }
}

/// A cap that comes down through bone of every density, slowly enough for windows of smooth motion.
SimulationInput exact_plunge(const std::string& device) {
  SimulationInput scene;
  scene.scenario = quiet_scenario(device);
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.bone.set_voxels(random_bone({41, 37, 29}, 0.2, 7));
  scene.tool = make_tool(cap_profile(5, 6, 3, 0.6), 64);
  const Quat tilt(Eigen::AngleAxisd(0.2, Vec3(1, 2, 0.5).normalized()));
  scene.motion = straight({1, 1, 4}, {0.9, 1.1, 3.2}, 400, 1000, 250, tilt);
  return scene;
}

TEST(ForceBasis, GivesTheForcesOfRerunsInWindows) {
  expect_forces_of_reruns(exact_plunge("auto"), "windows");
}

TEST(ForceBasis, GivesTheForcesOfRerunsFrameByFrame) {
  SimulationInput scene = exact_plunge("auto");
  scene.scenario.engine.tuning.windows = false;
  expect_forces_of_reruns(scene, "frame by frame");
}

TEST(ForceBasis, GivesTheForcesOfRerunsWithASizeEffect) {
  SimulationInput scene = exact_plunge("auto");
  scene.scenario.cutting.size_effect.emplace();
  expect_forces_of_reruns(scene, "size effect");
}

TEST(ForceBasis, GivesTheForcesOfRerunsBelowTheSpeedFloor) {
  SimulationInput scene = exact_plunge("auto");
  scene.scenario.cutting.speed_floor_mm_s = 40;
  expect_forces_of_reruns(scene, "speed floor");
}

TEST(ForceBasis, GivesTheForcesOfRerunsWithSeveralSubsteps) {
  SimulationInput scene = exact_plunge("auto");
  scene.motion = straight({1, 1, 4.4}, {0.9, 1.1, 2.2}, 6, 100, 250);
  expect_forces_of_reruns(scene, "several substeps");
}

TEST(ForceBasis, GivesTheForcesOfRerunsWithRemovedVoxels) {
  for (const char* device : {"auto", "serial"}) {
    SimulationInput scene = exact_plunge(device);
    scene.scenario.cutting.erosion = ErosionMode::remove;
    scene.motion = straight({1, 1, 4.4}, {0.9, 1.1, 3}, 12, 100, 250);
    scene.scenario.engine.max_step_voxels = 0.25;
    expect_forces_of_reruns(scene, std::string("remove, ") + device);
  }
}

TEST(ForceBasis, GivesTheForcesOfRerunsWithResolvedCuttingEdges) {
  SimulationInput scene = exact_plunge("auto");
  scene.scenario.tool.spin = ToolSpin::resolved;
  const TriangleMesh mesh = gear_mesh(4, 1.1, 2.0, 3);
  Tool tool;
  tool.mesh = mesh;
  tool.profile = envelope_of_revolution(mesh).profile;
  tool.shell = voxelize_surface(mesh, 40);
  tool.bounds = mesh.bounds();
  for (const Vec3& v : mesh.vertices) tool.reach_mm = std::max(tool.reach_mm, v.norm());
  tool.spin = ToolSpin::resolved;
  tool.teeth = make_distance_grid(mesh, tool.profile, 0.2);
  scene.tool = tool;
  scene.motion = straight({1.5, 1, 4}, {0.6, 1.4, 2.4}, 30, 100, 250);
  expect_forces_of_reruns(scene, "resolved cutting edges");
}

TEST(ForceBasis, HasAPartForTheEdgeForce) {
  SimulationInput scene = exact_plunge("auto");
  scene.scenario.cutting.edge_force.emplace();
  const ForceBasis basis(rows_of(scene, true).basis_rows);
  EXPECT_TRUE(std::ranges::any_of(basis.rows(), [](const BasisRow& row) { return row.grade == 0; }));
  for (const double factor : {1.0, 3.0}) {
    SimulationInput again = scene;
    again.scenario.cutting.edge_force->tangential_n_mm *= factor;
    again.scenario.cutting.edge_force->normal_n_mm *= factor * factor;
    again.scenario.cutting.specific_energy_j_mm3 *= 0.7;
    const BasisError error = error_of(basis, again.scenario.cutting, rows_of(again, false).results);
    std::cout << "edge force x" << factor << ": force " << error.force << ", torque " << error.torque << ", energy "
              << error.energy << '\n';
    EXPECT_LT(error.force, kSame);
    EXPECT_LT(error.torque, kSame);
    EXPECT_LT(error.energy, kSame);
    EXPECT_LT(error.work, 1e-6);
  }
}

std::string bytes_of(const std::vector<BasisRow>& rows) {
  return {reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(BasisRow)};
}

TEST(ForceBasis, IsTheSameOnEveryDeviceAndForEveryBatch) {
  const std::string reference = bytes_of(rows_of(exact_plunge("serial"), true).basis_rows);
  EXPECT_FALSE(reference.empty());
  for (const int batch : {1, 7, 1000}) {
    SimulationInput scene = exact_plunge("auto");
    scene.scenario.engine.batch_frames = batch;
    EXPECT_TRUE(bytes_of(rows_of(scene, true).basis_rows) == reference) << batch;
  }
}

TEST(ForceBasis, RemovedVolumeIsThatOfTheRun) {
  const RowSink run = rows_of(exact_plunge("auto"), true);
  double removed = 0, of_basis = 0;
  for (const FrameResult& result : run.results) removed += result.removed_mm3;
  for (const double volume : ForceBasis(run.basis_rows).volume_mm3()) of_basis += volume;
  EXPECT_NEAR(of_basis / removed, 1, 1e-6);
}

TEST(ForceBasisFile, IsReadAsItWasWritten) {
  const TempDir dir;
  const std::string path = dir.path() + "/force_basis.npy";
  const std::vector<BasisRow> rows = rows_of(exact_plunge("auto"), true).basis_rows;
  const std::vector<BasisRow> first(rows.begin(), rows.begin() + 10), rest(rows.begin() + 10, rows.end());
  std::uintmax_t bytes = 0;
  {
    ForceBasisWriter writer(path);
    writer.rows(first);
    bytes = writer.sync();
    writer.rows(rest);
    writer.close();
  }
  EXPECT_TRUE(bytes_of(read_force_basis(path)) == bytes_of(rows));
  {
    ForceBasisWriter writer(path, bytes);
    writer.rows(rest);
    writer.close();
  }
  EXPECT_TRUE(bytes_of(read_force_basis(path)) == bytes_of(rows)) << "continued";
  const std::string whole = file_bytes(path);
  for (const std::size_t size : {std::size_t{0}, std::size_t{100}, whole.size() - 1, whole.size() - sizeof(BasisRow)}) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, size);
    EXPECT_THROW(read_force_basis(path), InputError) << size;
  }
}

TEST(Recalibration, MovesDensitiesByTheirRadiodensity) {
  Recalibration same{{}, {}};
  for (const int grade : {1, 100, 250}) EXPECT_NEAR(same.density(grade), 0.008 * grade, 1e-12);
  Recalibration twice{{}, {}};
  twice.now.ash_slope_g_cm3_per_hu *= 2;
  twice.now.ash_offset_g_cm3 *= 2;
  EXPECT_NEAR(twice.density(100), 1.6, 1e-12);
  EXPECT_EQ(twice.density(200), 2) << "clamped";
}

}  // namespace
}  // namespace reamsim::test::force_basis_tests
