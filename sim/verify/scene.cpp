// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/verify/scene.h"

#include <fmt/core.h>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "sim/bone/voxmap/cube_fraction.h"

namespace reamsim::verify {

Profile ball_profile(double radius_mm, double edge_mm) {
  Profile profile;
  const int steps = static_cast<int>(std::ceil(radius_mm * std::numbers::pi / edge_mm));
  for (int i = 0; i <= steps; ++i) {
    const double angle = std::numbers::pi * i / steps;
    const bool pole = i == 0 || i == steps;
    profile.points.emplace_back(pole ? 0 : radius_mm * std::sin(angle), radius_mm - radius_mm * std::cos(angle));
  }
  return profile;
}

Profile convex_profile(double radius_mm, double outer_mm, double bore_mm, double height_mm, double edge_mm) {
  Profile profile;
  const double begin = std::asin(bore_mm / radius_mm), end = std::asin(outer_mm / radius_mm);
  const int steps = static_cast<int>(std::ceil(radius_mm * (end - begin) / edge_mm));
  for (int i = 0; i <= steps; ++i) {
    const double angle = begin + (end - begin) * i / steps;
    profile.points.emplace_back(radius_mm * std::sin(angle), radius_mm - radius_mm * std::cos(angle));
  }
  profile.points.emplace_back(outer_mm, height_mm);
  profile.points.emplace_back(bore_mm, height_mm);
  return profile;
}

Profile flat_profile(double outer_mm, double bore_mm, double height_mm) {
  return {{{bore_mm, 0}, {outer_mm, 0}, {outer_mm, height_mm}, {bore_mm, height_mm}}};
}

VoxelGrid block_grid(const Vec3& size_mm, double voxel_mm) {
  VoxelGrid grid;
  grid.voxel_mm = voxel_mm;
  for (int i = 0; i < 3; ++i) grid.dims[i] = 2 * static_cast<int>(std::ceil(size_mm[i] / (2 * voxel_mm) - 1e-9));
  const Vec3 extent_mm = voxel_mm * grid.dims.cast<double>();
  grid.origin_mm = {-extent_mm.x() / 2, -extent_mm.y() / 2, -extent_mm.z()};
  return grid;
}

FilledVoxmap block(const Vec3& size_mm, double voxel_mm, const DensityField& field) {
  return sample_phantom(block_grid(size_mm, voxel_mm), {}, field);
}

FilledVoxmap half_block(const Vec3& size_mm, double voxel_mm, const DensityField& field, const Vec3& point_mm,
                        const Vec3& inward) {
  const auto behind = [=](const Vec3& p) { return (point_mm - p).dot(inward); };
  return sample_phantom(
      block_grid(size_mm, voxel_mm), {}, [&](const Vec3& p) { return behind(p) < 0 ? field(p) : kAir; },
      [&](const Vec3& center, bool) {
        return PartialVoxel{fraction_inside(behind, center, voxel_mm), field(center)};
      });
}

FilledVoxmap block(const Vec3& size_mm, double voxel_mm, double density_g_cm3) {
  return block(size_mm, voxel_mm, [=](const Vec3&) { return density_g_cm3; });
}

Quat rotation(const Vec3& axis, double degrees) {
  return Quat(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()));
}

Motion path(double rate_hz, const Vec3& from_mm, const std::vector<Leg>& legs) {
  std::vector<ToolPose> poses{
      {.position_mm = from_mm, .orientation = legs.front().turned, .spin_rpm = legs.front().rpm}};
  for (const Leg& leg : legs) {
    const ToolPose begin = poses.back();
    for (int k = 1; k <= leg.frames; ++k) {
      const double fraction = double(k) / leg.frames;
      poses.push_back({.position_mm = begin.position_mm + fraction * (leg.to_mm - begin.position_mm),
                       .orientation = begin.orientation.slerp(fraction, leg.turned),
                       .spin_angle_rad = begin.spin_angle_rad + angular_speed(leg.rpm) * k / rate_hz,
                       .spin_rpm = leg.rpm});
    }
  }
  return {rate_hz, std::move(poses)};
}

Vec3 ball_origin(const Vec3& center_mm, double radius_mm, const Quat& turned) {
  return center_mm - turned * Vec3(0, 0, radius_mm);
}

SimulationInput scene_of(FilledVoxmap bone, Tool tool, Motion motion, ErosionMode erosion) {
  SimulationInput scene;
  scene.scenario.name = "verification";
  scene.scenario.cutting = stated_cutting(erosion);
  scene.scenario.render.enabled = false;
  scene.scenario.render.every_frames = std::numeric_limits<int>::max();
  scene.bone.set_voxels(std::move(bone));
  scene.tool = std::move(tool);
  scene.motion = std::move(motion);
  return scene;
}

namespace {

/// Collects the rows.
struct Rows final : FrameSink {
  void frame(const FrameResult& result, const FrameTimes& /*times*/) override { rows.push_back(result); }
  std::vector<FrameResult> rows;
};

constexpr double kPlungeClear_mm = 0.1;
constexpr double kEdge_mm = 0.1;
constexpr double kPlungeHead_mm = 8;  // height of a head

FilledVoxmap bone_of(const PlungeRun& run, const Vec3& size_mm) {
  const double density = run.plunge.density_g_cm3;
  if (!run.half_toward_deg) return block(size_mm, run.voxel_mm, density);
  return half_block(
      size_mm, run.voxel_mm, [=](const Vec3&) { return density; }, entry_mm(run.voxel_mm),
      toward(*run.half_toward_deg));
}

}  // namespace

Reamed ream(SimulationInput scene, const Setting& setting) {
  scene.scenario.engine.device = setting.device;
  const auto engine = setting.engine(scene.scenario, scene.bone, scene.tool);
  Rows sink;
  Diagnostics report;
  const SimulationState end = simulate(scene, *engine, sink, {.stop = setting.stop}, report);
  return {std::move(sink.rows), std::move(scene.bone), end.feed, end.springs};
}

MeanLoads mean_loads(std::span<const FrameResult> rows) {
  MeanLoads out;
  for (const FrameResult& row : rows) {
    out.force_n += row.force_n;
    out.torque_nmm += row.torque_nmm;
    out.axial_force_n += row.axial_force_n;
    out.spin_torque_nmm += row.spin_torque_nmm;
    out.removed_mm3 += row.removed_mm3;
  }
  const auto n = static_cast<double>(rows.size());
  out.force_n /= n;
  out.torque_nmm /= n;
  out.axial_force_n /= n;
  out.spin_torque_nmm /= n;
  return out;
}

double torque_ripple(std::span<const FrameResult> rows) {
  const double mean = mean_loads(rows).spin_torque_nmm;
  double squares = 0;
  for (const FrameResult& row : rows) squares += (row.spin_torque_nmm - mean) * (row.spin_torque_nmm - mean);
  return std::sqrt(squares / static_cast<double>(rows.size())) / mean;
}

double time_constant_s(const Reamed& reamed, std::size_t a, std::size_t b,
                       const std::function<double(const FrameResult&)>& missing) {
  const FrameResult &first = reamed.rows[a], &last = reamed.rows[b];
  return (last.time_s - first.time_s) / std::log(missing(first) / missing(last));
}

Vec3 entry_mm(double voxel_mm) {
  return {0.12 * voxel_mm, 0.21 * voxel_mm, 0};
}

Vec3 toward(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return {std::cos(angle), std::sin(angle), 0};
}

Profile head_of(const SteadyPlunge& plunge) {
  return plunge.radius_mm ? convex_profile(*plunge.radius_mm, plunge.outer_mm, plunge.bore_mm, kPlungeHead_mm, kEdge_mm)
                          : flat_profile(plunge.outer_mm, plunge.bore_mm, kPlungeHead_mm);
}

std::string text_of(const SteadyPlunge& p) {
  const std::string face = p.radius_mm ? "R " + std::to_string(static_cast<int>(*p.radius_mm)) : "flat";
  return fmt::format("{}, a {:g} mm, {:g} rpm, {:g} mm/s", face, p.outer_mm, p.rpm, p.feed_mm_s);
}

std::vector<FrameResult> steady_rows(const PlungeRun& run, const Setting& setting) {
  constexpr double kShellVoxels = 0.4721, kPast_mm = 0.3;
  const SteadyPlunge& plunge = run.plunge;
  const double voxel_mm = run.voxel_mm, travel_mm = run.voxels * voxel_mm;
  const int frames = run.voxels * run.frames;
  const Vec3 entry = entry_mm(voxel_mm);
  const double tilt = run.tilt_deg * std::numbers::pi / 180, slant = plunge.outer_mm * std::tan(tilt);
  const Quat turned = rotation({1, 0.3, 0}, run.tilt_deg);
  const Vec3 axis = turned * Vec3(0, 0, 1);
  const double begin = plunge.full_contact_mm() + slant + kPast_mm + 0.37 * voxel_mm, end = begin + travel_mm;
  const double rate = plunge.feed_mm_s * run.frames / voxel_mm, above = slant + kPlungeClear_mm;
  const Motion motion =
      path(rate, entry + above * axis,
           {{entry - begin * axis, static_cast<int>(std::ceil(10 * (begin + above))), plunge.rpm, turned},
            {entry - end * axis, frames, plunge.rpm, turned}});
  const double width = 2 * (plunge.outer_mm + end * std::tan(tilt)) + 2 + 2 * voxel_mm;
  const FilledVoxmap bone = bone_of(run, {width, width, end + slant + 1 + voxel_mm});
  const Tool tool = run.erosion == ErosionMode::exact ? make_tool(head_of(plunge))
                                                      : make_tool(head_of(plunge), kShellVoxels * voxel_mm);
  SimulationInput scene = scene_of(bone, tool, motion, run.erosion);
  scene.scenario.motion.compliance = run.compliance;
  const Reamed reamed = ream(std::move(scene), setting);
  const auto steady = reamed.after(reamed.rows.size() - 1 - static_cast<std::size_t>(frames));
  return {steady.begin(), steady.end()};
}

}  // namespace reamsim::verify
