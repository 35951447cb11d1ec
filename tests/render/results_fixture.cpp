// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/render/results_fixture.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "sim/bone/vdb/bone_vdb.h"
#include "sim/mesh/mesh_io.h"
#include "sim/record/recorder.h"

namespace reamsim {
namespace {

constexpr double kToolRadius_mm = 29;
constexpr double kHeadRadius_mm = 13;
constexpr double kHeadHeight_mm = 7;
constexpr double kFaceRadius_mm = 32;

/// Negative inside; mm; glenoid frame. Not an exact distance, but zero where the surface is.
double bone_distance(const Vec3& p) {
  const Vec3 radii(13.5, 18, 20);
  const Vec3 q = p - Vec3(0, 0, -16);
  const double ellipsoid = (q.cwiseQuotient(radii).norm() - 1) * 13.5;
  const double cup = kFaceRadius_mm - (p - Vec3(0, 0, kFaceRadius_mm)).norm();
  const double bump = (p - Vec3(0, 15, 0.5)).norm() - 3;
  return std::min(std::max(ellipsoid, cup), bump);
}

/// Negative inside the tool's head, whose lowest point is at `lowest` on the z axis of the glenoid frame.
double tool_distance(const Vec3& p, double lowest) {
  const double sphere = (p - Vec3(0, 0, lowest + kToolRadius_mm)).norm() - kToolRadius_mm;
  const double side = p.head<2>().norm() - kHeadRadius_mm;
  return std::max({sphere, side, p.z() - lowest - kHeadHeight_mm});
}

double density(const Vec3& p, double distance) {
  if (distance > -1.8) return 1.55;
  return 0.45 + 0.15 * std::sin(2.1 * p.x() + 1) * std::sin(1.7 * p.y() + 1) * std::sin(1.9 * p.z());
}

Rigid bone_from_glenoid() {
  // A left shoulder in LPS, roughly: +z of G lateral (+x of B), +y superior (+z of B).
  Mat3 axes;
  axes.col(2) = Vec3(0.9, -0.42, 0.1).normalized();
  axes.col(1) = (Vec3::UnitZ() - axes.col(2).z() * axes.col(2)).normalized();
  axes.col(0) = axes.col(1).cross(axes.col(2));
  Rigid out = Rigid::Identity();
  out.linear() = axes;
  out.translation() = Vec3(120, 170, -440);
  return out;
}

FilledVoxmap make_bone(const Rigid& frame, double voxel_mm) {
  VoxelGrid grid;
  grid.voxel_mm = voxel_mm;
  const Vec3 half(23, 23, 23);
  const Vec3 middle = frame * Vec3(0, 0, -15);
  grid.origin_mm = middle - half;
  grid.dims = Vec3i::Constant(static_cast<int>(std::ceil(2 * half.x() / voxel_mm / 8)) * 8);
  FilledVoxmap bone(grid);
  const Rigid glenoid_from_bone = frame.inverse();
  for (int k = 0; k < grid.dims.z(); ++k) {
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        const Vec3 p = glenoid_from_bone * grid.center_mm({i, j, k});
        const double distance = bone_distance(p);
        if (distance > 0) continue;
        bone.grade.set({i, j, k}, DensityMapping::grade_from_density(density(p, distance)));
      }
    }
  }
  return bone;
}

void cut(FilledVoxmap& bone, const Rigid& glenoid_from_bone, double lowest, bool whole_voxels) {
  const VoxelGrid& grid = bone.grid;
  for (int k = 0; k < grid.dims.z(); ++k) {
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        if (bone.grade.get({i, j, k}) == 0) continue;
        const double outside = tool_distance(glenoid_from_bone * grid.center_mm({i, j, k}), lowest) / grid.voxel_mm;
        const double left = whole_voxels ? (outside > 0 ? 1 : 0) : std::clamp(0.5 + outside, 0.0, 1.0);
        const auto fill = static_cast<std::uint16_t>(std::lround(left * FillBricks::kWhole));
        if (fill < bone.fill.get({i, j, k})) bone.fill.set({i, j, k}, fill);
      }
    }
  }
}

/// Turned from its profile (r, z): the spherical face, the head's side, its back, the shaft.
TriangleMesh make_tool() {
  std::vector<Vec2> profile;
  const double edge = std::asin(kHeadRadius_mm / kToolRadius_mm);
  for (int i = 0; i <= 12; ++i) {
    profile.emplace_back(kToolRadius_mm * std::sin(edge * i / 12), kToolRadius_mm * (1 - std::cos(edge * i / 12)));
  }
  profile.emplace_back(kHeadRadius_mm, kHeadHeight_mm);
  profile.emplace_back(4, kHeadHeight_mm + 2);
  profile.emplace_back(4, 60);
  profile.emplace_back(0, 60);
  TriangleMesh mesh;
  constexpr int kTurns = 72;
  for (const Vec2& p : profile) {
    for (int t = 0; t < kTurns; ++t) {
      const double turn = 2 * std::numbers::pi * t / kTurns;
      mesh.vertices.emplace_back(p.x() * std::cos(turn), p.x() * std::sin(turn), p.y());
    }
  }
  for (int row = 0; row + 1 < static_cast<int>(profile.size()); ++row) {
    for (int t = 0; t < kTurns; ++t) {
      const int a = row * kTurns + t;
      const int b = row * kTurns + (t + 1) % kTurns;
      if (profile[static_cast<std::size_t>(row)].x() > 0) mesh.triangles.push_back({a, b, b + kTurns});
      if (profile[static_cast<std::size_t>(row) + 1].x() > 0) mesh.triangles.push_back({a, b + kTurns, a + kTurns});
    }
  }
  return mesh;
}

std::string matrix_text(const Rigid& rigid) {
  std::ostringstream out;
  out.precision(17);
  for (int i = 0; i < 16; ++i) out << (i > 0 ? " " : "") << rigid.matrix()(i / 4, i % 4);
  return out.str();
}

/// Lowest point of the tool, glenoid z, at a fraction 0…1 of the run: down, a moment's dwell, out again.
double lowest_at(double fraction, double depth_mm) {
  constexpr double kApproach_mm = 2;
  if (fraction < 0.7) return kApproach_mm - (kApproach_mm + depth_mm) * fraction / 0.7;
  if (fraction < 0.8) return -depth_mm;
  return -depth_mm + 40 * (fraction - 0.8);
}

}  // namespace

FixtureTruth write_results(const std::string& dir, const FixtureOptions& options) {
  FixtureTruth truth;
  truth.bone_from_glenoid = bone_from_glenoid();
  truth.deepest_mm = options.depth_mm;
  const Rigid glenoid_from_bone = truth.bone_from_glenoid.inverse();
  FilledVoxmap bone = make_bone(truth.bone_from_glenoid, options.voxel_mm);
  const Quat orientation(Mat3(truth.bone_from_glenoid.linear()));
  std::ofstream csv(dir + "/forces.csv");
  csv << "frame,time_s,tool_x_mm,tool_y_mm,tool_z_mm,tool_qw,tool_qx,tool_qy,tool_qz,spin_rpm,spin_angle_rad,depth_mm,"
         "force_x_n,force_y_n,force_z_n,torque_x_nmm,torque_y_nmm,torque_z_nmm,axial_force_n,spin_torque_nmm,contacts,"
         "removed_mm3,energy_mj,floor_energy_mj,balance\n";
  double before_mm3 = bone.bone_mm3();
  double deepest = 100;
  write_snapshot(dir, 0, bone.fill);
  for (int frame = 1; frame <= options.frames; ++frame) {
    const double lowest = lowest_at(static_cast<double>(frame) / options.frames, options.depth_mm);
    deepest = std::min(deepest, lowest);
    if (frame % options.every == 0) {
      cut(bone, glenoid_from_bone, deepest, options.whole_voxels);
      write_snapshot(dir, frame, bone.fill);
    }
    const double now_mm3 = bone.bone_mm3();
    const Vec3 at = truth.bone_from_glenoid * Vec3(0, 0, lowest);
    const double force = std::max(0.0, -lowest) * 15;
    const Vec3 push = force * truth.bone_from_glenoid.linear().col(2);
    csv << frame << ',' << 0.05 * frame << ',' << at.x() << ',' << at.y() << ',' << at.z() << ',' << orientation.w()
        << ',' << orientation.x() << ',' << orientation.y() << ',' << orientation.z() << ",250," << 1.3 * frame << ','
        << std::max(0.0, -lowest) << ',' << push.x() << ',' << push.y() << ',' << push.z() << ",0,0,0," << force << ','
        << 17 * force << ",100," << before_mm3 - now_mm3 << ",0,0,0\n";
    before_mm3 = now_mm3;
  }
  Metadata metadata;
  if (options.glenoid) metadata.emplace_back("bone_from_glenoid", matrix_text(truth.bone_from_glenoid));
  metadata.emplace_back("erosion", options.whole_voxels ? "remove" : "exact");
  if (options.side != BodySide::unknown) metadata.emplace_back("bone_side", name_of(options.side));
  write_bone_vdb(dir + "/reamed.vdb", bone, {}, metadata);
  write_stl(dir + "/snapshots/tool.stl", make_tool());
  return truth;
}

}  // namespace reamsim
