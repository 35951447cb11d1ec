// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The first contact of a tool with a bone that lies askew to its voxels.
#include <iostream>
#include <sstream>

#include "sim/mesh/mesh_io.h"
#include "tests/engine/outcome.h"
#include "tests/support/mesh_shapes.h"

namespace reamsim::test::first_contact_tests {
namespace {

constexpr double kRadius_mm = 29;
constexpr double kVoxel_mm = 0.25;
constexpr double kStep_mm = 0.002;
constexpr int kFrames = 400;

/// A column of forces.csv, a number a frame.
std::vector<double> column(const std::string& forces, const std::string& name) {
  std::istringstream lines(forces);
  std::string line, cell;
  std::getline(lines, line);
  std::istringstream head(line);
  int wanted = 0;
  while (std::getline(head, cell, ',') && cell != name) ++wanted;
  std::vector<double> out;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (int i = 0; i <= wanted; ++i) std::getline(cells, cell, ',');
    out.push_back(std::stod(cell));
  }
  return out;
}

Tool ball() {
  Profile profile;
  constexpr int kSteps = 900;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = M_PI * i / kSteps;
    const double r = i == 0 || i == kSteps ? 0 : kRadius_mm * std::sin(angle);
    profile.points.emplace_back(r, kRadius_mm * (1 - std::cos(angle)));
  }
  return make_tool(profile, 64);
}

/// The ball comes down square onto the face of a block that is turned against the lattice.
SimulationInput onto_a_turned_block(SurfaceVoxels surface_voxels, const TempDir& dir) {
  const Quat turned(Eigen::AngleAxisd(0.35, Vec3(2, 1, 0.4).normalized()));
  TriangleMesh mesh = box_mesh({-12, -12, -4}, {12, 12, 0});
  for (Vec3& v : mesh.vertices) v = turned * v + Vec3(0.07, 0.11, 0.05);
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.scenario.bone.source = BoneSource::mesh;
  scene.scenario.bone.voxel_mm = kVoxel_mm;
  scene.scenario.bone.surface_voxels = surface_voxels;
  scene.scenario.bone.mesh.path = dir.path() + "/block.stl";
  scene.scenario.bone.mesh.cortical_mm = 10;
  write_stl(scene.scenario.bone.mesh.path, mesh);
  Diagnostics report;
  scene.bone = load_bone(with_surface_voxels(scene.scenario.bone, scene.scenario.cutting), report);
  scene.tool = ball();
  const auto origin = [&](double depth_mm) -> Vec3 { return turned * Vec3(0, 0, -depth_mm) + Vec3(0.07, 0.11, 0.05); };
  scene.motion = straight(origin(0), origin(kFrames * kStep_mm), kFrames, 1000, 250, turned);
  return scene;
}

/// How far the volume of each frame lies from the slice of the cap that the frame cuts: root mean square over the
/// frames' mean, and the largest.
struct Ripple {
  double rms = 0;
  double most = 0;
};

Ripple ripple(SurfaceVoxels surface_voxels) {
  const TempDir dir;
  const Outcome outcome = run(onto_a_turned_block(surface_voxels, dir));
  const std::vector<double> removed = column(outcome.forces, "removed_mm3");
  Ripple out;
  double mean = 0;
  for (std::size_t frame = 1; frame < removed.size(); ++frame) {
    const double depth_mm = (static_cast<double>(frame) - 0.5) * kStep_mm;
    const double truth = M_PI * (2 * kRadius_mm * depth_mm - depth_mm * depth_mm) * kStep_mm;
    out.rms += std::pow(removed[frame] - truth, 2) / kFrames;
    out.most = std::max(out.most, std::abs(removed[frame] - truth));
    mean += truth / kFrames;
  }
  return {std::sqrt(out.rms) / mean, out.most / mean};
}

TEST(FirstContact, GrowsWithoutStepsOnASurfaceAskewToTheVoxels) {
  const Ripple partial = ripple(SurfaceVoxels::automatic), whole = ripple(SurfaceVoxels::whole);
  std::cout << "partial voxels: RMS " << 100 * partial.rms << " %, most " << 100 * partial.most
            << " %; whole voxels: RMS " << 100 * whole.rms << " %, most " << 100 * whole.most << " %\n";
  EXPECT_LT(partial.rms, 0.02);
  EXPECT_LT(5 * partial.rms, whole.rms);
}

}  // namespace
}  // namespace reamsim::test::first_contact_tests
