// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/error.h"
#include "sim/bench/measure.h"
#include "sim/bench/peaks.h"
#include "sim/bench/sphere_scene.h"
#include "sim/bench/whole_frames.h"

namespace reamsim::bench {

namespace {

using sphere::block, sphere::cap, sphere::down_to, sphere::kDepthMm, sphere::kRadiusMm, sphere::kSphereFeedMmS,
    sphere::kSphereFrameS;

constexpr int kDepths = 4;            // at which frames are timed at the true feed
constexpr int kFramesOfDepth = 16;    // with erosion `remove`
constexpr int kWindowsOfDepth = 5;    // with `exact`, the first of them untimed
constexpr double kStepVoxels = 0.25;  // between the depths, where the shell's points have to miss no voxel

double cap_mm3(double depth_mm) {
  return std::numbers::pi * depth_mm * depth_mm * (kRadiusMm - depth_mm / 3);
}

/// The whole plunge with a shell; time per frame at the depths.
SphereRow plunge(Program& program, double voxel_mm, const BenchControl& control) {
  SphereRow row{.engine = program.label().engine, .erosion = ErosionMode::remove, .voxel_mm = voxel_mm};
  const double frame_mm = kSphereFeedMmS * kSphereFrameS;
  std::vector<double> ms;
  double voxels = 0;
  double depth = 0;
  // implicit: one step gives the same, because the tool at a depth contains all of its straight path.
  const double step_mm = row.engine == "implicit" ? kDepthMm : kStepVoxels * voxel_mm;
  for (int i = 1; i <= kDepths; ++i) {
    const double begin = kDepthMm * i / kDepths - kFramesOfDepth * frame_mm;
    while (depth < begin) {
      if (control.stop()) throw Interrupted();
      depth = std::min(begin, depth + step_mm);
      const Substep frame = down_to(depth, 0);
      voxels += program.run({&frame, 1}, true).removed;
    }
    std::vector<Substep> frames;
    for (int k = 1; k <= kFramesOfDepth; ++k) frames.push_back(down_to(begin + k * frame_mm, k));
    const BatchSample sample = program.run(frames, true);
    ms.push_back(1e3 * sample.total_s / kFramesOfDepth);
    voxels += sample.removed;
    depth = begin + kFramesOfDepth * frame_mm;
  }
  row.ms = spread_of(ms);
  row.removed_mm3 = voxels * std::pow(voxel_mm, 3);
  row.volume_error = row.removed_mm3 / cap_mm3(depth) - 1;
  return row;
}

/// The motions of `erosion: exact`: its windows at each depth.
std::vector<Motion> motions_at_depths() {
  std::vector<Motion> out;
  for (int i = 1; i <= kDepths; ++i) {
    const ToolPose last = down_to(kDepthMm * i / kDepths - kSphereFeedMmS * kSphereFrameS, 0).pose;
    out.push_back(straight_motion(last, kSphereFeedMmS, kWindowsOfDepth));
  }
  return out;
}

SphereRow exact_row(const FilledVoxmap& bone, const Tool& tool, const Plan& plan, const BenchControl& control) {
  ExactRuns runs{.bone = &bone, .tool = &tool, .motions = motions_at_depths(), .device = plan.device};
  const WholeFrames frames = time_whole_frames(runs, control);
  SphereRow row{.engine = "exact", .erosion = ErosionMode::exact, .voxel_mm = bone.grid.voxel_mm};
  row.ms = spread_of(frames.ms);
  row.removed_mm3 = frames.removed_mm3;
  row.volume_error = row.removed_mm3 / cap_mm3(kDepthMm) - 1;
  row.exact = {.kernel_ms = spread_of(frames.kernel_ms).median, .voxels = frames.voxels};
  const cl::DeviceInfo device = cl::choose_device(plan.device);
  if (device.gpu || device.compute_units < 2 || device.max_parts == 0) return row;
  runs.cores = 1;
  const WholeFrames one_core = time_whole_frames(runs, control);
  row.exact->one_core_ms = spread_of(one_core.ms);
  row.exact->one_core_kernel_ms = spread_of(one_core.kernel_ms).median;
  return row;
}

}  // namespace

void measure_spheres(const Plan& plan, const BenchControl& control, Findings& findings) {
  const bool exact = std::ranges::count(plan.engines, "exact") > 0;
  if (exact && !plan.sphere_voxels_mm.empty()) findings.peaks = measure_peaks(cl::choose_device(plan.device));
  for (const double voxel_mm : plan.sphere_voxels_mm) {
    const FilledVoxmap bone = block(voxel_mm);
    const Tool tool = cap(voxel_mm);
    const BenchSetup setup{&bone, &tool, bone.grid.bounds_mm(), shell_box(tool)};
    for (const std::string& engine : plan.engines) {
      control.progress("plunged sphere, " + engine + fmt::format(", voxels of {:g} mm", voxel_mm));
      const Place place{{engine, "deterministic"}, bone.grid.dims.x(), tool.shell.resolution, "sphere"};
      measure_or_skip(place, findings.skipped, [&] {
        findings.spheres.push_back(engine == "exact"
                                       ? exact_row(bone, tool, plan, control)
                                       : plunge(*make_engine_program(engine, plan.device, setup), voxel_mm, control));
      });
    }
  }
}

}  // namespace reamsim::bench
