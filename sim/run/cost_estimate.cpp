// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/cost_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/engine/common/substep.h"
#include "sim/engine/dense/dense_state.h"
#include "sim/engine/exact/brick_batch_plan.h"
#include "sim/record/force_log.h"
#include "sim/scenario/parse.h"
#include "sim/scene/clearance.h"
#include "sim/scene/contact_forecast.h"
#include "sim/tool/tool_path.h"

namespace reamsim {

namespace {

/// Motion of the tool between two tested poses, voxels.
constexpr double kStepVoxels = 2;
enum class BrickMark : std::uint8_t { air, whole, partial };

/// Bound of the tool's motion in a visit, mm.
double visit_shift(const SimulationInput& scene) {
  const double voxel_mm = scene.bone.voxmap->grid.voxel_mm;
  double substep_mm = 0;
  const auto& poses = scene.motion.poses;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    substep_mm = std::max(substep_mm, motion_bound_mm(poses[k - 1], poses[k], scene.tool.reach_mm));
  }
  substep_mm = std::min(substep_mm, scene.scenario.engine.max_step_voxels * voxel_mm);
  return std::min(RS_VISIT_SUBSTEPS * substep_mm, kVisitShiftVoxels * voxel_mm);
}

/// Marks the bricks of the lattice, and counts the partial ones.
std::vector<BrickMark> marks_of(const Bone& bone, const BrickLattice& lattice, std::size_t& partial) {
  std::vector<BrickMark> out(lattice.count(), BrickMark::air);
  bone.voxmap->grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
    const bool is_partial = bone.fill.brick(coord) != nullptr;
    out[lattice.index(coord)] = is_partial ? BrickMark::partial : BrickMark::whole;
    partial += is_partial ? 1 : 0;
  });
  return out;
}

constexpr int kWindows = 10;
constexpr std::int64_t kWindowFrames = 64;
/// Batches of the serial engine are small, because it is slow.
constexpr int kSerialBatch = 4;

class BatchTimes : public FrameSink {
 public:
  void frame(const FrameResult& result, const FrameTimes&) override {
    last_ = {watch_.seconds(), result.frame};
    if (result.frame == 0) end_batch();  // it is a batch of its own
  }
  void end_batch() { ends_.push_back(last_); }
  void snapshot(std::int64_t, FillBricks&) override { read_s_ = std::max(read_s_, watch_.seconds() - last_.first); }

  /// That of the fastest batch; the first may include the compilation of kernels.
  [[nodiscard]] double seconds_per_frame() const {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < ends_.size(); ++i) {
      const auto frames = static_cast<double>(ends_[i].second - ends_[i - 1].second);
      if (frames > 0) best = std::min(best, (ends_[i].first - ends_[i - 1].first) / frames);
    }
    return best;
  }
  [[nodiscard]] std::int64_t frames() const { return last_.second; }
  [[nodiscard]] double read_s() const { return read_s_; }

 private:
  Stopwatch watch_;
  double read_s_ = 0;
  using TimedFrame = std::pair<double, std::int64_t>;  // time when it was recorded, frame
  TimedFrame last_{0, 0};
  std::vector<TimedFrame> ends_;  // of batches
};

/// The middle of a window, and its time per frame.
struct Timed {
  double frame;
  double seconds_per_frame;
};

/// Integral of the time per frame: linear between the windows, constant before the first and after the last.
double integrate_s(const std::vector<Timed>& timed, double frames) {
  double sum = timed.front().frame * timed.front().seconds_per_frame +
               (frames - timed.back().frame) * timed.back().seconds_per_frame;
  for (std::size_t i = 1; i < timed.size(); ++i) {
    sum += 0.5 * (timed[i].frame - timed[i - 1].frame) * (timed[i].seconds_per_frame + timed[i - 1].seconds_per_frame);
  }
  return sum;
}

BatchTimes time_window(SimulationInput& scene, Engine& engine, double most_s) {
  BatchTimes times;
  Diagnostics discarded;
  RunControl control;
  const Stopwatch watch;
  control.progress = [&](std::int64_t, std::int64_t) { times.end_batch(); };
  control.stop = [&] { return watch.seconds() > most_s; };
  try {
    simulate(scene, engine, times, control, discarded);
  } catch (const Interrupted&) {
    // The window has used its time.
  }
  return times;
}

// Measured on a scapula of 0.1 mm voxels (memory_mb.peak_process of its summary).

/// The program and its libraries: a run of a small block peaks at 177 MB with the compiler. Mesa's OpenCL drivers,
/// where they are installed, add up to 15 MB (Debian 13).
constexpr double kProgramBytes = 1.4e8;
/// The kernel compiler, and heap memory retained from loading the bone.
constexpr double kCompilerBytes = 9e7;
/// Per brick on the surface, for `surface` of reamed.vdb: leaves of the smoothed occupancy and of the distances.
constexpr double kSurfaceBytes = 7'000;
/// A leaf of a FloatGrid.
constexpr double kLeafBytes = 2'200;
/// The serial engine's dense grades and fill, per voxel.
constexpr double kSerialBytes = 3;

/// A long run thins poses and rows to `most`; until then it holds all, and vectors double as they grow.
template <class Item>
double bytes_of_frames(double frames, std::size_t most) {
  return 2 * sizeof(Item) * std::min(frames, static_cast<double>(most));
}

struct BrickCounts {
  double partial = 0;  ///< with bone and air
  double mixed = 0;    ///< with more than one grade, air included
};

BrickCounts count_bricks(const GradeBricks& grades) {
  BrickCounts out;
  grades.for_each_brick([&out](const Vec3i&, const GradeBricks::Brick& brick) {
    const auto [least, most] = std::minmax_element(brick.begin(), brick.end());
    out.partial += *least == 0 ? 1 : 0;
    out.mixed += *least != *most ? 1 : 0;
  });
  return out;
}

/// The surface is computed first, and freed before all grids are written.
double results_bytes(const BrickCounts& bricks) {
  const double grids = kLeafBytes * (bricks.mixed + bricks.partial + 1.6 * bricks.partial);
  return std::max(kSurfaceBytes * bricks.partial, grids);
}

std::size_t planned_device_bytes(const SimulationInput& scene, const ExactForecast& forecast) {
  const Scenario& scenario = scene.scenario;
  const BoneView bone = scene.bone;
  if (scenario.engine.device == "serial") return 0;
  const EngineKind engine = engine_of(scenario);
  if (engine == EngineKind::exact) return exact_engine_bytes(bone, scene.tool, forecast);
  if (engine == EngineKind::bricked) return bricked_engine_bytes(scenario, bone, scene.tool);
  return plan_dense(engine, bone, scene.tool, scenario.cutting.erosion == ErosionMode::wear).bytes();
}

}  // namespace

ExactForecast forecast_exact(const SimulationInput& scene) {
  ExactForecast out;
  const Tool& tool = scene.tool;
  const VoxelGrid& grid = scene.bone.voxmap->grid;
  const BrickLattice lattice = BrickLattice::over(grid.dims);
  const VoxelBox bone = bone_extent(*scene.bone.voxmap);
  std::vector<BrickMark> marks = marks_of(scene.bone, lattice, out.partial);
  const DistanceTable coarse = brick_distances(tool.profile, grid.voxel_mm, tool.clip_slack_mm());
  const double sample_slack_mm = std::sqrt(0.5) * coarse.pitch_mm + 1e-3;  // between a point and its sample
  BoundedPath path(tool.reach_mm, kStepVoxels * grid.voxel_mm);
  path.add(scene.motion.poses);
  const double step_mm = path.step_mm();
  const std::vector<PathSample> samples = sample_path(path.finish(), tool.reach_mm, step_mm);
  const double reached_mm = RS_BRICK_RADIUS * grid.voxel_mm + (step_mm + path.deviation_mm());
  const double listed_mm = reached_mm + visit_shift(scene) + sample_slack_mm;
  const Aabb box = tool.clip_bounds().expanded(listed_mm);
  for (const PathSample& sample : samples) {
    const Substep rest{.pose = sample.pose, .duration_s = scene.motion.frame_s()};
    const SubstepArgs args = make_args(rest, box, tool.shell, grid, scene.scenario.cutting, false);
    const VoxelBox near = voxel_voi(args, box, bone);
    if (near.empty()) continue;
    std::size_t listed = 0;
    const Eigen::Affine3d place = tool_from_voxel(args);
    for_each_voxel(near.first / BrickLattice::kSide, near.last / BrickLattice::kSide, [&](const Vec3i& brick) {
      BrickMark& mark = marks[lattice.index(brick)];
      if (mark == BrickMark::air) return;
      const Vec3 middle =
          (BrickLattice::kSide * brick).cast<double>() + Vec3::Constant(0.5 * (BrickLattice::kSide - 1));
      const Vec2 rz = rz_of(place * middle);
      double distance_mm = coarse.nearest(rz);
      if (std::abs(distance_mm - reached_mm) <= sample_slack_mm) distance_mm = tool.profile.nearest(rz).distance_mm;
      listed += std::abs(distance_mm) <= listed_mm ? 1 : 0;
      if (distance_mm > reached_mm || mark == BrickMark::partial) return;
      ++out.partial;
      mark = BrickMark::partial;
    });
    out.listed = std::max(out.listed, listed);
  }
  return out;
}

TimePlan plan_time(SimulationInput& scene, Engine& engine, double budget_s) {
  const Motion motion = scene.motion;
  const PoseSequence& poses = motion.poses;
  std::vector<Pass> later_passes = std::exchange(scene.later_passes, {});
  scene.motion.first_frame = 0;
  scene.motion.push.reset();  // its way without resistance is timed
  const Scenario original = scene.scenario;
  scene.scenario.render.every_frames = std::numeric_limits<int>::max();  // no snapshots in between
  if (original.engine.device == "serial") scene.scenario.engine.batch_frames = kSerialBatch;
  const auto all = static_cast<std::int64_t>(poses.size()) - 1;
  const std::int64_t window = std::min(all, kWindowFrames);
  const auto first_of = [&](int i) { return (all - window) * i / (kWindows - 1); };
  TimePlan plan;
  std::vector<Timed> timed;
  double read_s = 0;
  const Stopwatch watch;
  for (int i = 0; i < kWindows && window > 0 && watch.seconds() < budget_s; ++i) {
    const std::int64_t first = first_of(i);
    if (i > 0 && first == first_of(i - 1)) continue;  // a run shorter than the windows
    scene.motion.poses = poses.part(static_cast<std::size_t>(first), static_cast<std::size_t>(window) + 1);
    const BatchTimes times = time_window(scene, engine, budget_s / kWindows);
    read_s = std::max(read_s, times.read_s());
    const auto frames = static_cast<double>(times.frames());
    if (frames == 0) continue;
    timed.push_back({static_cast<double>(first) + 0.5 * frames, times.seconds_per_frame()});
    plan.timed_frames += times.frames();
  }
  plan.windows = static_cast<int>(timed.size());
  scene.motion = motion;
  scene.later_passes = std::move(later_passes);
  scene.scenario = original;
  if (timed.empty()) return plan;
  // A snapshot is read back and written to disk, which takes about as long.
  const auto in_pass = [&](std::int64_t frame) { return frame >= motion.first_frame && frame <= motion.last_frame(); };
  const auto snapshots = static_cast<double>(
      std::ranges::count_if(picture_frames(original.render, scene.last_frame(), scene.contact), in_pass));
  plan.simulate_s = integrate_s(timed, static_cast<double>(all)) + 2 * snapshots * read_s;
  return plan;
}

MemoryPlan plan_memory(const SimulationInput& scene) {
  const Voxmap& voxmap = *scene.bone.voxmap;
  const bool exact = scene.scenario.cutting.erosion == ErosionMode::exact;
  const ExactForecast forecast = exact ? forecast_exact(scene) : ExactForecast{};
  MemoryPlan plan{.device_bytes = planned_device_bytes(scene, forecast)};

  const double voxels = static_cast<double>(voxmap.grade.count());
  const double loading = scene.scenario.bone.source == BoneSource::mesh ? kMeshBytesPerVoxel * voxels : 0;
  const bool serial = scene.scenario.engine.device == "serial";
  const double engine =
      serial ? kSerialBytes * static_cast<double>(voxmap.grid.size()) : static_cast<double>(plan.device_bytes);
  // The fill at the start of the run, and the current one where it differs.
  const double fill = static_cast<double>(scene.bone.fill.bytes() + sizeof(FillBricks::Brick) * forecast.partial);
  BrickCounts bricks = count_bricks(voxmap.grade);
  // The reamed face is part of the surface.
  bricks.partial += static_cast<double>(forecast.listed);
  bricks.mixed += static_cast<double>(forecast.listed);
  const double resident = static_cast<double>(voxmap.grade.bytes()) + fill;
  const auto frames = static_cast<double>(scene.motion.poses.size());
  // What is held of the frames uses the memory that the compiler has left.
  const double of_frames = bytes_of_frames<PathSample>(frames, BoundedPath::kMost) +
                           bytes_of_frames<ForceRow>(frames, LogOptions{}.most_rows);
  const double held =
      std::max(serial ? 0 : kCompilerBytes, of_frames) + 2 * static_cast<double>(scene.motion.key_bytes);
  // The engine is freed before the results are written.
  const double most = std::max(loading, resident + held + std::max(engine, results_bytes(bricks)));
  plan.process_bytes = static_cast<std::size_t>(kProgramBytes + most);
  return plan;
}

RunEstimate RunEstimator::estimate(const Scenario& scenario, RunResources& resources) {
  const Stopwatch watch;
  Diagnostics report;
  SimulationInput scene = load_scene(scenario, report, resources.bones);
  RunEstimate out{.load_s = watch.seconds(), .frames = scene.last_frame(), .warnings = {}};
  warn_of_contact(scene, forecast_passes(scene), report);
  if (const auto clearance = find_clearance(scene)) warn_of_clearance(*clearance, scene, report);
  out.warnings = report.warnings;
  do {
    out.memory_bytes = std::max(out.memory_bytes, plan_memory(scene).process_bytes);
    out.simulate_s += simulate_s(scene, resources);
  } while (begin_next_pass(scene));
  return out;
}

double RunEstimator::simulate_s(SimulationInput& scene, RunResources& resources) {
  constexpr double kTiming_s = 0.1;
  const auto frames = static_cast<double>(scene.motion.last_frame() - scene.motion.first_frame + 1);
  const std::vector<PassSpec> passes = passes_of(scene.scenario);
  const std::tuple key{resources.bones->loaded(), passes[static_cast<std::size_t>(scene.motion.pass) - 1].tool.mesh,
                       scene.scenario.output.force_basis};
  const auto known = s_per_frame_.find(key);
  if (known != s_per_frame_.end()) return known->second * frames;
  const auto engine = load_engine(scene, resources.devices);  // also finds what does not fit the device
  const double seconds = plan_time(scene, *engine, kTiming_s).simulate_s;
  s_per_frame_[key] = seconds / std::max(1.0, frames);
  return seconds;
}

}  // namespace reamsim
