// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/scene.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "sim/base/parallel.h"
#include "sim/bench/paper.h"
#include "sim/bone/implicit.h"
#include "sim/bone/phantom.h"
#include "sim/bone/voxmap/sample_voxels.h"
#include "sim/run/frame_stepper.h"
#include "sim/tool/point_shell.h"
#include "sim/tool/profile.h"

namespace reamsim::bench {

namespace {

constexpr double kFaceRadiusMm = 32;  // of the phantom's glenoid face, a sphere about a point on the x axis
constexpr double kFrameS = 1e-3;
constexpr double kFeedMmS = 1;
constexpr double kSpinRpm = 250;

constexpr double kWidthMm = 30;            // of the sphere's cap
constexpr double kSpacingVoxels = 0.4721;  // what `reamsim run` chooses

/// The face is oriented towards +x; behind it the cube extends into the neck.
const Vec3 kBoxCornerMm(-30, -20, -20);

VoxelGrid grid_of(int side) {
  return {Vec3i::Constant(side), kBoxMm / side, kBoxCornerMm};
}

/// The grades of `dims` voxels from `low` on, x fastest. Beyond the lattice they are those of its outer voxels.
std::vector<int> grades_from(const Voxmap& coarse, const Vec3i& low, const Vec3i& dims) {
  const Vec3i last = coarse.grid.dims - Vec3i::Ones();
  std::vector<int> out;
  for_each_voxel(dims,
                 [&](const Vec3i& step) { out.push_back(coarse.grade.get((low + step).cwiseMax(0).cwiseMin(last))); });
  return out;
}

/// A brick of the finer voxmap: a voxel is bone where the interpolated fraction of bone is at least half, with the mean
/// grade of the bone about it. The factor is a power of two, so that weights and their sums are exact.
void refine_brick(const Voxmap& coarse, int factor, const Vec3i& coord, GradeBricks::Brick& out) {
  // The centre of a fine voxel in coarse ones, from the centre of the first.
  const auto place_of = [factor](const Vec3i& fine) -> Vec3 {
    return (fine.cast<double>().array() + 0.5) / factor - 0.5;
  };
  const Vec3i low = place_of(GradeBricks::kSide * coord).array().floor().cast<int>();
  const Vec3i dims = Vec3i::Constant(GradeBricks::kSide / factor + 2);
  const std::vector<int> grades = grades_from(coarse, low, dims);
  if (std::ranges::count(grades, 0) == std::ssize(grades)) return;
  for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
    const Vec3 place = place_of(BrickLattice::voxel_at(coord, offset)) - low.cast<double>();
    const Vec3i lower = place.array().floor().cast<int>();
    double bone = 0, sum = 0;
    for_each_trilinear_weight(place - lower.cast<double>(), [&](const Vec3i& step, double weight) {
      const int grade = grades[index_in(dims, lower + step)];
      bone += grade != 0 ? weight : 0;
      sum += weight * grade;
    });
    if (bone < 0.5) continue;
    out[static_cast<std::size_t>(offset)] = static_cast<std::uint8_t>(sum / bone);
  }
}

FilledVoxmap refine(const Voxmap& coarse, int side) {
  FilledVoxmap fine(grid_of(side));
  const int factor = side / coarse.grid.dims.x();
  fine.grade = sample_bricks(fine.grid.dims, [&](const Vec3i& coord, GradeBricks::Brick& brick) {
    refine_brick(coarse, factor, coord, brick);
  });
  return fine;
}

/// Mean grade of the bone among factor³ voxels, air where less than half of them are bone.
std::uint8_t merged(const Voxmap& fine, const Vec3i& first, int factor) {
  int bone = 0, grade = 0;
  for_each_voxel(Vec3i::Constant(factor), [&](const Vec3i& offset) {
    const int g = fine.grade.get(first + offset);
    bone += g != 0;
    grade += g;
  });
  return static_cast<std::uint8_t>(2 * bone >= factor * factor * factor ? grade / bone : 0);
}

FilledVoxmap merge(const Voxmap& fine, int side) {
  FilledVoxmap coarse(grid_of(side));
  const int factor = fine.grid.dims.x() / side;
  for_each_voxel(coarse.grid.dims, [&](const Vec3i& voxel) {
    if (const std::uint8_t grade = merged(fine, factor * voxel, factor); grade != 0) coarse.grade.set(voxel, grade);
  });
  return coarse;
}

/// Points of a sphere whose lowest point is the origin, from there to a polar angle.
Profile arc(double radius_mm, double angle_rad, int steps) {
  Profile profile;
  for (int i = 0; i <= steps; ++i) {
    const double angle = angle_rad * i / steps;
    profile.points.emplace_back(radius_mm * std::sin(angle), radius_mm * (1 - std::cos(angle)));
  }
  return profile;
}

}  // namespace

BoneSeries::BoneSeries(int sampled)
    : sampled_(sample_glenoid({.source = BoneSource::phantom, .side = BodySide::left}, grid_of(sampled))),
      box_mm_(bone_box(sampled_)) {}

FilledVoxmap BoneSeries::at(int side) const {
  const int sampled = sampled_.grid.dims.x();
  FilledVoxmap out = side == sampled ? sampled_ : side > sampled ? refine(sampled_, side) : merge(sampled_, side);
  out.mapping = sampled_.mapping;
  out.frame = sampled_.frame;
  return out;
}

Aabb BoneSeries::box(int side) const {
  const VoxelGrid grid = grid_of(side);
  if (side >= sampled_.grid.dims.x()) return box_mm_;
  const Vec3 low = ((box_mm_.min - grid.origin_mm) / grid.voxel_mm).array().floor();
  const Vec3 high = ((box_mm_.max - grid.origin_mm) / grid.voxel_mm).array().ceil();
  return {grid.origin_mm + grid.voxel_mm * low, grid.origin_mm + grid.voxel_mm * high};
}

Tool cap_tool(int resolution) {
  constexpr double kFacetCells = 0.02;
  const int cells = std::max(2, static_cast<int>(std::lround(kCapFraction * resolution)));
  Tool tool;
  // A hemisphere, closed by a lid that the shell does not have.
  tool.profile = arc(kReamerMm, std::numbers::pi / 2, 96);
  tool.profile.points.back() = {kReamerMm, kReamerMm};
  tool.profile.points.emplace_back(0, kReamerMm);
  const double cell_mm = 2 * kReamerMm / (cells - 1);
  tool.mesh = revolve(tool.profile, segments_for_sagitta(kReamerMm, kFacetCells * cell_mm));
  tool.bounds = tool.mesh.bounds();
  TriangleMesh cap = tool.mesh;
  std::erase_if(cap.triangles, [&](const auto& triangle) {
    return std::all_of(triangle.begin(), triangle.end(), [&](std::int32_t vertex) {
      return cap.vertices[static_cast<std::size_t>(vertex)].z() == kReamerMm;
    });
  });
  tool.shell = voxelize_surface(cap, cells);
  tool.shell.resolution = resolution;  // the codes fill a corner of the larger grid
  tool.reach_mm = std::numbers::sqrt2 * kReamerMm + cell_mm;
  return tool;
}

Tool make_tool(const Profile& profile, std::optional<double> shell_spacing_mm) {
  constexpr int kUnusedCells = 8;  // of a shell that exact erosion does not use
  Tool tool;
  tool.profile = profile;
  tool.bounds = profile.bounds();
  const double radius = tool.bounds.max.x(), low = tool.bounds.min.z(), high = tool.bounds.max.z();
  if (shell_spacing_mm) {
    const double longest = std::max(2 * radius, high - low);
    tool.mesh = revolve(profile, segments_for_sagitta(radius, 0.02 * *shell_spacing_mm));
    tool.shell = voxelize_surface(tool.mesh, static_cast<int>(std::ceil(longest / *shell_spacing_mm)) + 1);
  } else {
    tool.mesh = revolve({{{0, low}, {radius, low}, {radius, high}, {0, high}}}, 4 * kUnusedCells);
    tool.shell = voxelize_surface(tool.mesh, kUnusedCells);
  }
  for (const Vec2& rz : profile.points) tool.reach_mm = std::max(tool.reach_mm, rz.norm());
  return tool;
}

const std::array<Approach, 4> kApproaches{{
    {0, 0, 3, -2, {0.7520, 0.0576, -0.4399}},
    {-3, 4, 8, -6, {0.4102, -0.2905, -0.7692}},
    {4, -6, -12, 10, {-0.1914, -0.8999, -1.3996}},
    {1, -3, 18, 15, {-1.0703, -2.2725, -2.8603}},
}};

const char* name_of(Contact contact) {
  return contact == Contact::severe ? "severe" : contact == Contact::light ? "light" : "none";
}

ToolPose pose_at(const Approach& approach, double depth_mm) {
  const double y = approach.posterior_mm, z = approach.superior_mm;
  const Vec3 center(kFaceRadiusMm, 0, 0);
  const Vec3 place(kFaceRadiusMm - std::sqrt(kFaceRadiusMm * kFaceRadiusMm - y * y - z * z), y, z);
  const Vec3 axis =
      Eigen::AngleAxisd(implicit::radians(approach.tilt_posterior_deg), Vec3::UnitZ()) *
      (Eigen::AngleAxisd(-implicit::radians(approach.tilt_up_deg), Vec3::UnitY()) * (center - place).normalized());
  const Quat turned = smallest_rotation(Vec3::UnitZ(), axis);
  return {.position_mm = place - depth_mm * axis, .orientation = turned, .spin_rpm = kSpinRpm};
}

Substep substep_at(const ToolPose& pose) {
  const Vec3 axis = pose.orientation * Vec3::UnitZ();
  return {.pose = pose,
          .origin_velocity_mm_s = -kFeedMmS * axis,
          .angular_velocity = -kSpinRpm * 2 * std::numbers::pi / 60 * axis,
          .duration_s = kFrameS,
          .frame = 1};
}

std::vector<Substep> substeps_of(Contact contact) {
  std::vector<Substep> out;
  for (const Approach& approach : kApproaches) {
    out.push_back(substep_at(pose_at(approach, approach.depth_mm[static_cast<std::size_t>(contact)])));
  }
  return out;
}

SubstepArgs args_without_voi(const Substep& substep, const Tool& tool, const VoxelGrid& grid) {
  SubstepArgs args = make_args(substep, shell_box(tool), tool.shell, grid, bench_cutting(), false);
  for (int axis = 0; axis < 3; ++axis) {
    args.voi_min[axis] = 0;
    args.voi_max[axis] = tool.shell.resolution - 1;
  }
  return args;
}

std::int64_t count_touching(const Voxmap& voxmap, const Tool& tool, const Substep& substep) {
  const SubstepArgs args = args_without_voi(substep, tool, voxmap.grid);
  const auto& codes = tool.shell.codes;
  std::atomic<std::int64_t> total = 0;
  parallel_ranges(codes.size(), 8192, [&](std::size_t begin, std::size_t end) {
    std::int64_t sum = 0;
    for (std::size_t i = begin; i < end; ++i)
      sum += voxmap.is_bone(voxel_of_cell(args, morton_decode(codes[i]))) ? 1 : 0;
    total += sum;
  });
  return total;
}

double wanted_points(Contact contact, double points) {
  const double fraction = points / kPaperPoints.back();
  return contact == Contact::severe  ? kSeverePoints * fraction
         : contact == Contact::light ? kLightPoints * fraction
                                     : 0;
}

FilledVoxmap sphere_block(double voxel_mm) {
  const Vec3 size_mm(kWidthMm + 4, kWidthMm + 4, kSphereDepthMm + 2);
  VoxelGrid grid;
  grid.voxel_mm = voxel_mm;
  for (int i = 0; i < 3; ++i) grid.dims[i] = 8 * static_cast<int>(std::ceil(size_mm[i] / voxel_mm / 8));
  const Vec3 extent = voxel_mm * grid.dims.cast<double>();
  grid.origin_mm = {-extent.x() / 2 + 0.37 * voxel_mm, -extent.y() / 2 + 0.21 * voxel_mm, -extent.z()};
  FilledVoxmap voxmap(grid);
  voxmap.grade = sample_bricks(
      grid.dims, [](const Vec3i&, GradeBricks::Brick& out) { out.fill(DensityMapping::grade_from_density(1.8)); });
  voxmap.frame = "phantom";
  return voxmap;
}

Tool sphere_cap(double voxel_mm) {
  Profile profile = arc(kSphereRadiusMm, std::asin(kWidthMm / 2 / kSphereRadiusMm), 64);  // exact takes the arc itself
  profile.points.emplace_back(kWidthMm / 2, 8);
  profile.points.emplace_back(0, 8);
  constexpr double kMostCells = 1022.5;  // along the cap: 1024 with those at its ends
  return make_tool(profile, std::max(kSpacingVoxels * voxel_mm, kWidthMm / kMostCells));
}

Substep sphere_frame(double depth_mm, std::int64_t number) {
  Substep frame = substep_at({.position_mm = {0, 0, -depth_mm}, .spin_rpm = 250});
  frame.origin_velocity_mm_s = {0, 0, -kSphereFeedMmS};
  frame.duration_s = kSphereFrameS;
  frame.frame = number;
  return frame;
}

}  // namespace reamsim::bench
