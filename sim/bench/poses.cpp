// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/poses.h"

#include <atomic>
#include <cmath>
#include <numbers>

#include "sim/base/error.h"
#include "sim/base/parallel.h"
#include "sim/bench/paper.h"
#include "sim/tool/morton.h"

namespace reamsim::bench {

namespace {

constexpr double kFaceRadiusMm = 32;  // of the phantom's glenoid face, a sphere about a point on the x axis
constexpr double kFrameS = 1e-3;
constexpr double kFeedMmS = 1;
constexpr double kSpinRpm = 250;

bool touches(const Voxmap& voxmap, const SubstepArgs& args, std::uint64_t code) {
  const Vec3i cell = morton_decode(code);
  const int x = cell.x(), y = cell.y(), z = cell.z();
  const Vec3i voxel(rs_voxel_coordinate(&args, 0, x, y, z), rs_voxel_coordinate(&args, 1, x, y, z),
                    rs_voxel_coordinate(&args, 2, x, y, z));
  if (!voxmap.grid.contains(voxel)) return false;
  return voxmap.grade.get(voxel) != 0;
}

}  // namespace

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
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180; };
  const Vec3 axis = Eigen::AngleAxisd(radians(approach.tilt_posterior_deg), Vec3::UnitZ()) *
                    (Eigen::AngleAxisd(-radians(approach.tilt_up_deg), Vec3::UnitY()) * (center - place).normalized());
  ToolPose pose;
  pose.orientation = smallest_rotation(Vec3::UnitZ(), axis);
  pose.position_mm = place - depth_mm * axis;
  pose.spin_rpm = kSpinRpm;
  return pose;
}

Substep substep_at(const ToolPose& pose) {
  const Vec3 axis = pose.orientation * Vec3::UnitZ();
  Substep out;
  out.pose = pose;
  out.origin_velocity_mm_s = -kFeedMmS * axis;
  out.angular_velocity = -kSpinRpm * 2 * std::numbers::pi / 60 * axis;
  out.duration_s = kFrameS;
  out.frame = 1;
  return out;
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
    for (std::size_t i = begin; i < end; ++i) sum += touches(voxmap, args, codes[i]) ? 1 : 0;
    total += sum;
  });
  return total;
}

double find_depth(const Voxmap& voxmap, const Tool& tool, const Approach& approach, double wanted) {
  double low = -8, high = 8;  // mm: clear of the bone, deep in it
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    const auto count = static_cast<double>(count_touching(voxmap, tool, substep_at(pose_at(approach, middle))));
    if (wanted > 0 && std::abs(count - wanted) < 0.002 * wanted) return middle;
    (count > wanted ? high : low) = middle;
  }
  return wanted > 0 ? (low + high) / 2 : low - kClearance_mm;
}

double wanted_points(Contact contact, double points) {
  const double fraction = points / kPaperPoints.back();
  return contact == Contact::severe  ? kSeverePoints * fraction
         : contact == Contact::light ? kLightPoints * fraction
                                     : 0;
}

}  // namespace reamsim::bench
