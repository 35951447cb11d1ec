// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/bench/measure.h"
#include "sim/record/recorder.h"
#include "sim/run/simulation.h"

namespace reamsim::bench {

namespace {

constexpr std::int64_t kWindowFrames = 64;  // kernels/window.h
constexpr double kRateHz = 1000;

/// Runs of `erosion: exact`, to be timed, each on the whole bone. Bone and tool are the caller's.
struct ExactRuns {
  const FilledVoxmap* bone = nullptr;
  const Tool* tool = nullptr;
  std::vector<Motion> motions;  ///< see straight_motion(); the first pose removes what is inside the tool
  std::string device = "auto";
  int cores = 0;  ///< compute units of the device; 0: all
};

/// Frames of ExactRuns, timed over the whole windows of 64 frames of each run but its first. A whole frame is what
/// `reamsim run` does: substeps, broad phase, windows, kernels, sums read, rows of forces.csv and timings.csv written.
struct WholeFrames {
  std::vector<double> ms;         ///< per whole frame, by window
  std::vector<double> kernel_ms;  ///< of it: kernels, by the clock of the device
  double voxels = 0;              ///< that lose bone in a frame, mean
  double removed_mm3 = 0;         ///< in the whole of the last run
  StructureBytes bytes;
};

/// The path of a new folder, which is removed with it.
std::shared_ptr<const std::string> temporary_folder() {
  std::string path = (std::filesystem::temp_directory_path() / "reamsim-bench-XXXXXX").string();
  if (mkdtemp(path.data()) == nullptr) throw RunError(path + ": cannot be created");
  return {new std::string(path), [](const std::string* folder) {
            std::error_code ignored;
            std::filesystem::remove_all(*folder, ignored);
            delete folder;
          }};
}

/// Writes rows and adds up what the frames report.
struct CountingSink final : FrameSink {
  CountingSink(double voxel_mm, const std::string& dir) : recorder(dir, voxel_mm) {}

  void frame(const FrameResult& result, const FrameTimes& times) override {
    recorder.frame(result, times);
    contacts += result.contacts;
  }
  [[nodiscard]] double kernel_s() const { return recorder.totals().times.detect_s + recorder.totals().times.cut_s; }

  Recorder recorder;
  std::int64_t contacts = 0;
};

SimulationInput scene_of(const ExactRuns& runs, const Motion& motion) {
  SimulationInput scene;
  scene.scenario.name = "bench";
  scene.scenario.cutting = bench_cutting();
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.scenario.engine.device = runs.device;
  scene.scenario.engine.tuning.compute_units = runs.cores;
  scene.scenario.engine.batch_frames = static_cast<int>(kWindowFrames);
  scene.scenario.render.every_frames = std::numeric_limits<int>::max();  // a snapshot ends a batch
  scene.bone.set_voxels(FilledVoxmap(*runs.bone));
  scene.tool = *runs.tool;
  scene.motion = motion;
  return scene;
}

/// Times a run, and adds its windows to `out`. Returns the voxels that lose bone, summed over the timed frames.
double time_run(const ExactRuns& runs, const Motion& motion, const BenchControl& control, WholeFrames& out) {
  SimulationInput scene = scene_of(runs, motion);
  const std::unique_ptr<Engine> engine = load_engine(scene);
  const auto folder = temporary_folder();
  CountingSink sink(runs.bone->grid.voxel_mm, *folder);
  Stopwatch watch;
  double kernel_before_s = 0;
  std::int64_t contacts_before = 0, contacts = 0;
  RunControl hooks{.stop = control.stop};
  hooks.progress = [&](std::int64_t frame, std::int64_t last) {
    if (frame == last) return;
    if (frame >= kWindowFrames) {
      out.ms.push_back(1e3 * watch.seconds() / kWindowFrames);
      out.kernel_ms.push_back(1e3 * (sink.kernel_s() - kernel_before_s) / kWindowFrames);
    } else {
      contacts_before = sink.contacts;
    }
    contacts = sink.contacts;
    kernel_before_s = sink.kernel_s();
    watch = Stopwatch();
  };
  Diagnostics report;
  simulate(scene, *engine, sink, hooks, report);
  out.removed_mm3 = sink.recorder.totals().removed_mm3;
  out.bytes = engine->structure_bytes();
  return static_cast<double>(contacts - contacts_before);
}

/// Runs the main loop (sim/run/simulation.h) with its files in temporary folders. Throws Interrupted, RunError,
/// InputError.
WholeFrames time_whole_frames(const ExactRuns& runs, const BenchControl& control) {
  WholeFrames out;
  double voxels = 0;
  for (const Motion& motion : runs.motions) voxels += time_run(runs, motion, control, out);
  out.voxels = voxels / static_cast<double>(kWindowFrames * std::ssize(out.ms));
  return out;
}

/// A straight motion at 1 kHz along −z of T, of `windows` windows of 64 frames, which end at `last`, and one frame
/// more: the last frame of a run includes that its fill is read back.
Motion straight_motion(const ToolPose& last, double feed_mm_s, int windows) {
  std::vector<ToolPose> poses;
  const std::int64_t frames = kWindowFrames * windows;
  const Vec3 up = last.orientation * Vec3::UnitZ();
  for (std::int64_t k = 0; k <= frames; ++k) {
    ToolPose pose = last;
    pose.position_mm += static_cast<double>(frames - 1 - k) * feed_mm_s / kRateHz * up;
    poses.push_back(pose);
  }
  return {kRateHz, std::move(poses)};
}

constexpr int kDepths = 4;            // at which frames are timed at the true feed
constexpr int kFramesOfDepth = 16;    // with erosion `remove`
constexpr int kWindowsOfDepth = 5;    // with `exact`, the first of them untimed
constexpr double kStepVoxels = 0.25;  // between the depths, where the shell's points have to miss no voxel

/// A row of the report: time per frame of the plunged sphere at 0.2 mm/s and 1 kHz, and the volume's error down to
/// `depth_mm`. `exact`: whole frames with the rows of forces.csv, by window of 64; others: from the pose to the sums,
/// by depth. null: what only `exact` has.
Json sphere_row(const std::string& engine, ErosionMode erosion, double voxel_mm, const Spread& ms, double removed_mm3,
                double depth_mm) {
  const double cap_mm3 = std::numbers::pi * depth_mm * depth_mm * (kSphereRadiusMm - depth_mm / 3);
  Json row{{"engine", engine}, {"erosion", name_of(erosion)}, {"voxel_mm", voxel_mm}};
  row.update(spread_ms(ms));
  row.update({{"times_real_time", 1 / ms.median},
              {"kernel_ms", nullptr},
              {"one_core_ms", nullptr},
              {"one_core_kernel_ms", nullptr},
              {"voxels", nullptr},
              {"removed_mm3", removed_mm3},
              {"volume_error", removed_mm3 / cap_mm3 - 1},
              {"samples", ms.samples}});
  return row;
}

/// The whole plunge with a shell; time per frame at the depths.
Json plunge(Program& program, double voxel_mm, const BenchControl& control) {
  const double frame_mm = kSphereFeedMmS * kSphereFrameS;
  std::vector<double> ms;
  double voxels = 0;
  double depth = 0;
  // implicit: one step gives the same, because the tool at a depth contains all of its straight path.
  const double step_mm = program.label().engine == "implicit" ? kSphereDepthMm : kStepVoxels * voxel_mm;
  for (int i = 1; i <= kDepths; ++i) {
    const double begin = kSphereDepthMm * i / kDepths - kFramesOfDepth * frame_mm;
    while (depth < begin) {
      if (control.stop()) throw Interrupted();
      depth = std::min(begin, depth + step_mm);
      const Substep frame = sphere_frame(depth, 0);
      voxels += program.run({&frame, 1}, true).removed;
    }
    std::vector<Substep> frames;
    for (int k = 1; k <= kFramesOfDepth; ++k) frames.push_back(sphere_frame(begin + k * frame_mm, k));
    const BatchSample sample = program.run(frames, true);
    ms.push_back(1e3 * sample.total_s / kFramesOfDepth);
    voxels += sample.removed;
    depth = begin + kFramesOfDepth * frame_mm;
  }
  return sphere_row(program.label().engine, ErosionMode::remove, voxel_mm, spread_of(ms),
                    voxels * std::pow(voxel_mm, 3), depth);
}

/// Also the median device time of a frame, and the voxels that lose bone in it; and the times on one compute unit of a
/// processor with several, if its driver can divide it.
Json exact_row(const FilledVoxmap& bone, const Tool& tool, const Plan& plan, const BenchControl& control) {
  ExactRuns runs{.bone = &bone, .tool = &tool, .motions = {}, .device = plan.device};
  for (int i = 1; i <= kDepths; ++i) {
    const ToolPose last = sphere_frame(kSphereDepthMm * i / kDepths - kSphereFeedMmS * kSphereFrameS, 0).pose;
    runs.motions.push_back(straight_motion(last, kSphereFeedMmS, kWindowsOfDepth));
  }
  const WholeFrames frames = time_whole_frames(runs, control);
  Json row = sphere_row("exact", ErosionMode::exact, bone.grid.voxel_mm, spread_of(frames.ms), frames.removed_mm3,
                        kSphereDepthMm);
  row["kernel_ms"] = spread_of(frames.kernel_ms).median;
  row["voxels"] = frames.voxels;
  const cl::DeviceInfo device = cl::choose_device(plan.device);
  if (!device.gpu && device.compute_units >= 2 && device.max_parts > 0) {
    runs.cores = 1;
    const WholeFrames one_core = time_whole_frames(runs, control);
    row["one_core_ms"] = spread_of(one_core.ms).median;
    row["one_core_kernel_ms"] = spread_of(one_core.kernel_ms).median;
  }
  return row;
}

constexpr int kWindowsOfCase = 3;     // the first of them untimed
constexpr int kWindowsOfPlunge = 16;  // 1024 frames
constexpr double kCaseFeedMmS = 1;    // as the other engines' substeps (scene.h)

/// The motions of a case: to the depth of each approach; without one: as measure_plunge().
std::vector<Motion> motions_of(std::optional<Contact> contact, double voxel_mm) {
  std::vector<Motion> out;
  if (!contact) {
    const double step_mm = 0.25 * voxel_mm, rate_hz = 1000;
    const double depth_mm = kApproaches[0].depth_mm[1] + step_mm * 64 * kWindowsOfPlunge;
    return {straight_motion(pose_at(kApproaches[0], depth_mm), step_mm * rate_hz, kWindowsOfPlunge)};
  }
  for (const Approach& approach : kApproaches) {
    const double depth_mm = approach.depth_mm[static_cast<std::size_t>(*contact)];
    out.push_back(straight_motion(pose_at(approach, depth_mm), kCaseFeedMmS, kWindowsOfCase));
  }
  return out;
}

}  // namespace

void measure_spheres(const Plan& plan, const BenchControl& control,
                     const std::function<void(const std::string&)>& begin, Json& report) {
  const bool exact = std::ranges::count(plan.engines, "exact") > 0;
  if (exact && !plan.sphere_voxels_mm.empty()) report["peaks"] = measure_peaks(cl::choose_device(plan.device));
  for (const double voxel_mm : plan.sphere_voxels_mm) {
    const FilledVoxmap bone = sphere_block(voxel_mm);
    const Tool tool = sphere_cap(voxel_mm);
    const BenchSetup setup{&bone, &tool, bone.grid.bounds_mm(), shell_box(tool)};
    for (const std::string& engine : plan.engines) {
      begin("plunged sphere, " + engine + fmt::format(", voxels of {:g} mm", voxel_mm));
      const Label label{engine, "deterministic"};
      const SizePair size{bone.grid.dims.x(), tool.shell.resolution};
      measure_or_skip(case_row(label, size, "sphere"), report, [&] {
        report["spheres"].push_back(engine == "exact"
                                        ? exact_row(bone, tool, plan, control)
                                        : plunge(*make_program(label, plan.device, setup), voxel_mm, control));
      });
    }
  }
}

void measure_exact_case(const ProgramSet& set, std::optional<Contact> contact) {
  if (std::ranges::count(set.plan.engines, "exact") == 0) return;
  const Json at = case_row({"exact", "deterministic"}, set.size, contact ? name_of(*contact) : "plunge");
  const ExactRuns runs{.bone = set.setup.voxmap,
                       .tool = set.setup.tool,
                       .motions = motions_of(contact, set.setup.voxmap->grid.voxel_mm),
                       .device = set.plan.device};
  measure_or_skip(at, set.report, [&] {
    const WholeFrames frames = time_whole_frames(runs, set.control);
    add_result(at, frames.voxels, spread_of(frames.ms), spread_of(frames.kernel_ms).median, set.report);
    if (contact == Contact::severe) add_memory("exact", set.size, {frames.bytes.voxmap, 0}, set.report);
  });
}

}  // namespace reamsim::bench
