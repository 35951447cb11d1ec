// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/motion_windows.h"

#include <algorithm>
#include <array>
#include <utility>

#include "sim/engine/common/tables.h"

namespace reamsim {

// The struct has the same layout on host and device.
static_assert(sizeof(MotionWindow) == 3 * sizeof(SubstepArgs) + 16);

namespace {

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

Mat3 step_of(const SubstepArgs& args) {
  return Eigen::Map<const Mat3>(args.tool_from_voxel).transpose();  // stored row by row
}

Vec3 vector_of(const float* values) {
  return Eigen::Map<const Eigen::Vector3f>(values).cast<double>();
}

PointMotion motion_of(const SubstepArgs& args, const Vec3& lattice_point, const Vec3& tool_point) {
  return {step_of(args) * lattice_point + Eigen::Map<const Vec3>(args.tool_origin),
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
  const Vec3 point = step_of(w.middle).inverse() * (corner - Eigen::Map<const Vec3>(w.middle.tool_origin));
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
  const std::span<const std::optional<SubstepArgs>> all(args_);
  std::int64_t begin = first, stop = end;
  while (begin < stop && kBlock * block_ + begin < 1) ++begin;
  while (begin < stop && kBlock * block_ + stop - 1 > last_) --stop;
  const std::int64_t count = stop - begin;
  if (count < kFewestFrames) return;
  const auto frames = all.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(count));
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
