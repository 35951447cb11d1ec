// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/substep.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "sim/engine/common/tables.h"
#include "sim/tool/tool_path.h"

namespace reamsim {

namespace {

std::int64_t fixed_point(double voxels) {
  return static_cast<std::int64_t>(std::floor(std::ldexp(voxels, RS_POSITION_BITS) + 0.5));
}

/// In RS_LENGTH_SCALE; a tool that is too far away for it reaches no bone.
std::int64_t fixed_length(double mm) {
  constexpr double kFarthest = 1e18;
  return std::llround(std::clamp(mm * RS_LENGTH_SCALE, -kFarthest, kFarthest));
}

/// First and last shell cell along an axis whose centre can lie in [low, high] mm from the shell's corner, with one
/// more on both sides for the rounding of fixed-point positions.
std::pair<int, int> cell_range(double low, double high, const PointShell& shell) {
  const double first = std::floor(low / shell.cell_mm - 0.5) - 1, last = std::ceil(high / shell.cell_mm - 0.5) + 1;
  const auto clamp = [&](double c) { return static_cast<int>(std::clamp(c, 0.0, shell.resolution - 1.0)); };
  return {clamp(first), clamp(last)};
}

/// The parameters of force law and erosion; zeros for options that are off. `spin_rate`: rad/s, unsigned.
void set_law(const CuttingSettings& cutting, double duration_s, double spin_rate, SubstepArgs& args) {
  constexpr double kTurn = 2 * M_PI;
  args.law = cutting.law == CuttingLaw::per_point ? RS_LAW_PER_POINT : RS_LAW_ENERGY;
  args.erosion = cutting.erosion == ErosionMode::exact  ? RS_EROSION_EXACT
                 : cutting.erosion == ErosionMode::wear ? RS_EROSION_WEAR
                                                        : RS_EROSION_REMOVE;
  const double wear = std::min(cutting.wear_g_cm3_per_s * duration_s, DensityMapping::kMaxDensity_g_cm3);
  args.wear = std::llround(RS_WHOLE_FILL * wear * RS_DENSITY_SCALE);
  args.duration = static_cast<float>(duration_s);
  args.per_duration = static_cast<float>(1 / duration_s);
  args.speed_floor = static_cast<float>(cutting.speed_floor_mm_s);
  args.per_speed_floor = static_cast<float>(1 / cutting.speed_floor_mm_s);
  args.floor_rate = static_cast<float>(1 / (cutting.speed_floor_mm_s * duration_s));
  args.normal_ratio = static_cast<float>(cutting.normal_ratio);
  args.force_per_point = static_cast<float>(cutting.force_per_point_n);
  if (const auto& size = cutting.size_effect) {
    // Without spin the time between two cutting edges is infinite; the chip thickness is limited anyway.
    constexpr double kLongest_s = 1e9;
    const double period_s =
        spin_rate > 0 ? std::min(kTurn / (size->cutting_edges * spin_rate), kLongest_s) : kLongest_s;
    args.size_exponent = static_cast<float>(size->exponent);
    args.chip_per_speed = static_cast<float>(period_s / size->reference_mm);
    args.min_chip = static_cast<float>(size->least_mm / size->reference_mm);
    args.max_chip = static_cast<float>(size->most_mm / size->reference_mm);
  }
  if (const auto& edge = cutting.edge_force) {
    args.edge_tangential = static_cast<float>(edge->tangential_n_mm * edge->cutting_edges / kTurn);
    args.edge_normal = static_cast<float>(edge->normal_n_mm * edge->cutting_edges / kTurn);
  }
}

/// Rounding allowance for axes that are cross products of nearly parallel edges.
constexpr double kParallelEpsilon = 1e-12;
/// Rounding allowance of the voxel box: more than the error of the kernels' single precision, voxels.
constexpr double kVoxelSlack = 0.05;

constexpr std::int64_t kBlock = RS_WINDOW_SUBSTEPS;
/// Fewer frames do not repay the fit.
constexpr std::int64_t kFewestFrames = 8;
/// Largest deviation of a frame's motion and velocity from the polynomials through the nodes, as a fraction; the loss
/// and the force of a single frame are wrong by as much.
constexpr double kDeviation = 1e-4;
/// Longest way in a window, voxels: on a longer one more voxels pass more depths than a window has cubics.
constexpr double kLongestVoxels = 0.2;
static_assert(2 * kLongestVoxels < kWindowShiftVoxels);
/// Rounding of positions in double precision, mm.
constexpr double kRoundingMm = 1e-10;

/// Motion of a corner of the tool's box through a frame: place of the lattice point that lies there in the middle node,
/// T, mm, and velocity of the tool there, mm/s.
struct PointMotion {
  Vec3 place;
  Vec3 velocity;
};

Vec3 vector_of(const float* values) {
  return Eigen::Map<const Eigen::Vector3f>(values).cast<double>();
}

PointMotion motion_of(const SubstepArgs& args, const Vec3& lattice_point, const Vec3& tool_point) {
  return {tool_from_voxel(args) * lattice_point,
          vector_of(args.origin_velocity) + vector_of(args.angular_velocity).cross(tool_point)};
}

/// The quadratic through the nodes at `first` and `last`, about the middle one.
Vec3 between(const MotionWindow& w, const Vec3& first, const Vec3& middle, const Vec3& last, double time) {
  const double t0 = double{w.first_time}, t1 = double{w.last_time};
  const Vec3 a = (first - middle) / t0, b = (last - middle) / t1;
  const Vec3 c2 = (b - a) / (t1 - t0);
  return middle + time * (a - t0 * c2 + time * c2);
}

/// Whether a corner of the tool's box moves as the nodes say, in all frames, and by less than `longest_mm`.
bool is_smooth(const MotionWindow& w, std::span<const std::optional<SubstepArgs>> frames, const Vec3& corner,
               double longest_mm) {
  const Vec3 point = tool_from_voxel(w.middle).inverse() * corner;
  const PointMotion first = motion_of(w.first, point, corner), middle = motion_of(w.middle, point, corner),
                    last = motion_of(w.last, point, corner);
  const double way = (middle.place - first.place).norm() + (last.place - middle.place).norm();
  if (way > longest_mm) return false;
  const double most_mm = kDeviation * way / static_cast<double>(frames.size()) + kRoundingMm;
  const double most_mm_s = kDeviation * middle.velocity.norm() + kRoundingMm;
  Vec3 before = Vec3::Zero();
  for (const std::optional<SubstepArgs>& args : frames) {
    const double time = double{rs_window_time(&w, args->frame)};
    const PointMotion here = motion_of(*args, point, corner);
    const Vec3 off = here.place - between(w, first.place, middle.place, last.place, time);
    if ((off - before).norm() > most_mm) return false;
    const Vec3 velocity = between(w, first.velocity, middle.velocity, last.velocity, time);
    if ((here.velocity - velocity).norm() > most_mm_s) return false;
    before = off;
  }
  return true;
}

}  // namespace

rs_i32 least_loss(double voxel_mm) {
  constexpr double kPositionMm = 1e-5;
  return 1 + static_cast<rs_i32>(std::ceil(RS_WHOLE_FILL * kPositionMm / voxel_mm));
}

int count_substeps(const ToolPose& a, const ToolPose& b, const Tool& tool, bool spin_resolved, double max_step_mm) {
  double step = motion_bound_mm(a, b, tool.reach_mm);
  if (spin_resolved) step += std::abs(b.spin_angle_rad - a.spin_angle_rad) * tool.profile.max_radius_mm();
  return std::max(1, static_cast<int>(std::ceil(step / max_step_mm - 1e-9)));
}

Substep make_substep(const ToolPose& a, const ToolPose& b, double begin_fraction, double end_fraction, double frame_s,
                     std::int64_t frame) {
  const ToolPose begin = interpolate(a, b, begin_fraction);
  Substep out;
  out.pose = interpolate(a, b, end_fraction);
  out.duration_s = (end_fraction - begin_fraction) * frame_s;
  out.frame = frame;
  out.origin_velocity_mm_s = (out.pose.position_mm - begin.position_mm) / out.duration_s;
  const double spin = (out.pose.spin_angle_rad - begin.spin_angle_rad) / out.duration_s;
  out.angular_velocity = rotation_vector(begin.orientation, out.pose.orientation) / out.duration_s -
                         spin * (out.pose.orientation * Vec3::UnitZ());
  return out;
}

Rigid bone_from_shell(const ToolPose& pose, bool spin_resolved) {
  Rigid out = pose.bone_from_tool();
  // Positive spin is about −z of T (docs/scenario.md).
  if (spin_resolved) out.rotate(Eigen::AngleAxisd(-pose.spin_angle_rad, Vec3::UnitZ()));
  return out;
}

Eigen::Affine3d tool_from_voxel(const SubstepArgs& args) {
  using Fixed = Eigen::Matrix<std::int64_t, 3, 3, Eigen::RowMajor>;
  const Mat3 brick = Eigen::Map<const Fixed>(args.tool_from_brick).cast<double>() / RS_LENGTH_SCALE;
  const Vec3 middle = Eigen::Map<const Eigen::Matrix<std::int64_t, 3, 1>>(args.brick_origin).cast<double>();
  Eigen::Affine3d out;
  out.linear() = brick / RS_BRICK_SIDE;
  out.translation() = middle / RS_LENGTH_SCALE - out.linear() * Vec3::Constant(double{RS_BRICK_MIDDLE});
  out.makeAffine();
  return out;
}

SubstepArgs make_args(const Substep& substep, const Aabb& voi, const PointShell& shell, const VoxelGrid& grid,
                      const CuttingSettings& cutting, bool spin_resolved) {
  SubstepArgs args{};
  const Rigid shell_pose = bone_from_shell(substep.pose, spin_resolved);
  const Vec3 first_cell = shell.origin_mm + Vec3::Constant(0.5 * shell.cell_mm);
  const Vec3 first = (shell_pose * first_cell - grid.origin_mm) / grid.voxel_mm;
  const Mat3 step = shell_pose.linear() * (shell.cell_mm / grid.voxel_mm);
  const Mat3 tool_from_bone = substep.pose.orientation.toRotationMatrix().transpose();
  const Mat3 step_mm = tool_from_bone * grid.voxel_mm;
  const Vec3 brick_middle = grid.origin_mm + Vec3::Constant(0.5 * RS_BRICK_SIDE * grid.voxel_mm);
  const Vec3 origin = tool_from_bone * (brick_middle - substep.pose.position_mm);
  const Vec3 velocity = tool_from_bone * substep.origin_velocity_mm_s;
  const Vec3 angular_velocity = tool_from_bone * substep.angular_velocity;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      args.voxel_from_cell[3 * i + j] = fixed_point(step(i, j));
      args.tool_from_brick[3 * i + j] = fixed_length(RS_BRICK_SIDE * step_mm(i, j));
      args.tool_step[3 * i + j] = static_cast<float>(step_mm(i, j));
      args.lattice_from_tool[3 * i + j] = static_cast<float>(tool_from_bone(j, i));
    }
    args.voxel_origin[i] = fixed_point(first[i]);
    args.brick_origin[i] = fixed_length(origin[i]);
    args.origin_velocity[i] = static_cast<float>(velocity[i]);
    args.angular_velocity[i] = static_cast<float>(angular_velocity[i]);
    args.shell_origin[i] = fixed_length(first_cell[i]);
    args.dims[i] = grid.dims[i];
    std::tie(args.voi_min[i], args.voi_max[i]) =
        cell_range(voi.min[i] - shell.origin_mm[i], voi.max[i] - shell.origin_mm[i], shell);
  }
  args.cell = fixed_length(shell.cell_mm);
  args.voxel_mm = static_cast<float>(grid.voxel_mm);
  args.per_voxel_mm = static_cast<float>(1 / grid.voxel_mm);
  args.min_loss = least_loss(grid.voxel_mm);
  args.frame = static_cast<std::int32_t>(substep.frame);
  const double spin = spin_resolved ? substep.pose.spin_angle_rad : 0;
  args.spin_cos = static_cast<float>(std::cos(spin));
  args.spin_sin = static_cast<float>(std::sin(spin));
  set_law(cutting, substep.duration_s, std::abs(angular_velocity.z()), args);
  return args;
}

bool boxes_overlap(const Aabb& a, const Aabb& b, const Rigid& a_from_b) {
  const Mat3 rotation = a_from_b.linear();
  const Mat3 abs_rotation = rotation.cwiseAbs().array() + kParallelEpsilon;
  const Vec3 offset = a_from_b * b.center() - a.center();
  const Vec3 half_a = a.half(), half_b = b.half();

  if ((offset.cwiseAbs().array() > (half_a + abs_rotation * half_b).array()).any()) return false;
  const Vec3 offset_in_b = rotation.transpose() * offset;
  if ((offset_in_b.cwiseAbs().array() > (half_b + abs_rotation.transpose() * half_a).array()).any()) return false;

  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double reach_a = half_a[i1] * abs_rotation(i2, j) + half_a[i2] * abs_rotation(i1, j);
      const double reach_b = half_b[j1] * abs_rotation(i, j2) + half_b[j2] * abs_rotation(i, j1);
      const double distance = std::abs(offset[i2] * rotation(i1, j) - offset[i1] * rotation(i2, j));
      if (distance > reach_a + reach_b) return false;
    }
  }
  return true;
}

std::optional<Aabb> volume_of_interest(const Aabb& tool, const Aabb& bone, const Rigid& tool_from_bone) {
  const Vec3 center = tool_from_bone * bone.center();
  const Vec3 half = tool_from_bone.linear().cwiseAbs() * bone.half();
  const Aabb voi{tool.min.cwiseMax(center - half), tool.max.cwiseMin(center + half)};
  return voi.empty() ? std::nullopt : std::optional(voi);
}

std::optional<Aabb> broad_phase(const Aabb& tool, const Aabb& bone, const Rigid& tool_from_bone) {
  if (!boxes_overlap(tool, bone, tool_from_bone)) return std::nullopt;
  return volume_of_interest(tool, bone, tool_from_bone);
}

VoxelBox voxel_voi(const SubstepArgs& args, const Aabb& tool_box, const VoxelBox& bone) {
  const Eigen::Affine3d voxel_from_tool = tool_from_voxel(args).inverse();
  const Vec3 center = voxel_from_tool * tool_box.center();
  const Vec3 half = voxel_from_tool.linear().cwiseAbs() * tool_box.half() + Vec3::Constant(kVoxelSlack);
  VoxelBox voi;
  for (int i = 0; i < 3; ++i) {
    // Clamped before the conversion: the voxel of a distant tool overflows an int.
    const double low = std::ceil(center[i] - half[i]), high = std::floor(center[i] + half[i]);
    voi.first[i] = static_cast<int>(std::clamp(low, double(bone.first[i]), bone.last[i] + 1.0));
    voi.last[i] = static_cast<int>(std::clamp(high, bone.first[i] - 1.0, double(bone.last[i])));
  }
  return voi;
}

MotionWindows::MotionWindows(ArgsOfFrame args_of, std::int64_t last, const Aabb& tool_box)
    : args_of_(std::move(args_of)), last_(last), tool_box_(tool_box) {}

std::shared_ptr<const MotionWindow> MotionWindows::of(std::int64_t frame) {
  if (frame / kBlock != block_) plan(frame / kBlock);
  return windows_[static_cast<std::size_t>(frame % kBlock)];
}

void MotionWindows::plan(std::int64_t block) {
  block_ = block;
  args_.assign(kBlock, std::nullopt);
  windows_.assign(kBlock, nullptr);
  for (std::int64_t i = 0; i < kBlock; ++i) {
    const std::int64_t frame = kBlock * block + i;
    if (frame >= 1 && frame <= last_) args_[static_cast<std::size_t>(i)] = args_of_(frame);
  }
  split(0, kBlock);
}

/// Makes a window of the frames `first` to `end` - 1 of the block, or of their halves. Frames without a substep at
/// either end, before the motion and after it, do not count.
void MotionWindows::split(std::int64_t first, std::int64_t end) {
  std::int64_t begin = first, stop = end;
  while (begin < stop && kBlock * block_ + begin < 1) ++begin;
  while (begin < stop && kBlock * block_ + stop - 1 > last_) --stop;
  const std::int64_t count = stop - begin;
  if (count < kFewestFrames) return;
  const std::span<const std::optional<SubstepArgs>> frames(args_.data() + begin, static_cast<std::size_t>(count));
  const bool single = std::ranges::all_of(frames, [](const auto& args) { return args.has_value(); });
  if (single) {
    auto window = std::make_shared<MotionWindow>();
    const auto middle = static_cast<std::size_t>(count / 2);
    window->first = *frames.front();
    window->middle = *frames[middle];
    window->last = *frames.back();
    window->per_frame = 2.0F / static_cast<float>(count);
    window->first_time = rs_window_time(window.get(), window->first.frame);
    window->last_time = rs_window_time(window.get(), window->last.frame);
    const double longest_mm = kLongestVoxels * double{window->first.voxel_mm};
    bool smooth = true;
    for (int c = 0; c < 8 && smooth; ++c) smooth = is_smooth(*window, frames, tool_box_.corner(c), longest_mm);
    if (smooth) {
      std::fill(windows_.begin() + begin, windows_.begin() + stop, window);
      return;
    }
  }
  if (end - first < 2 * kFewestFrames) return;
  split(first, (first + end) / 2);
  split((first + end) / 2, end);
}

}  // namespace reamsim
