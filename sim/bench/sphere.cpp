#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/error.h"
#include "sim/bench/measure.h"
#include "sim/bench/sphere_scene.h"

namespace reamsim::bench {

namespace {

using sphere::block, sphere::cap, sphere::down_to, sphere::kDepthMm, sphere::kRadiusMm, sphere::kSphereFeedMmS,
    sphere::kSphereFrameS;

constexpr int kWindows = 4;         // depths at which frames are timed at the true feed
constexpr int kWindowFrames = 256;  // at each: four windows of smooth motion (kernels/window.h)
constexpr std::int64_t kAligned = 64;
constexpr double kStepVoxels = 0.25;  // between the windows, where the shell's points have to miss no voxel

/// The whole plunge; time per frame of the windows.
SphereRow plunge(Program& program, ErosionMode erosion, double voxel_mm, const BenchControl& control) {
  SphereRow row{.engine = program.label().engine, .erosion = erosion, .voxel_mm = voxel_mm};
  const double frame_mm = kSphereFeedMmS * kSphereFrameS;
  std::vector<double> ms;
  double voxels = 0;
  double depth = 0;
  // implicit: one step gives the same, because the tool at a depth contains all of its straight path.
  const double step_mm = row.engine == "implicit" ? kDepthMm : kStepVoxels * voxel_mm;
  for (int window = 1; window <= kWindows; ++window) {
    const auto last = std::lround(kDepthMm * window / kWindows / frame_mm / kAligned) * kAligned;
    const std::int64_t first = last - kWindowFrames;
    const double begin = static_cast<double>(first) * frame_mm;
    while (depth < begin) {
      if (control.stop()) throw Interrupted();
      depth = std::min(begin, depth + step_mm);
      const Substep frame = down_to(depth, 0);
      voxels += program.run({&frame, 1}, true).removed;
    }
    std::vector<Substep> frames;
    for (std::int64_t k = first; k < last; ++k) frames.push_back(down_to(static_cast<double>(k) * frame_mm, k));
    const BatchSample sample = program.run(frames, true);
    ms.push_back(1e3 * sample.total_s / kWindowFrames);
    voxels += sample.removed;
    depth = begin + (kWindowFrames - 1) * frame_mm;
  }
  row.ms = spread_of(ms);
  row.removed_mm3 = voxels * std::pow(voxel_mm, 3);
  const double cap_mm3 = std::numbers::pi * depth * depth * (kRadiusMm - depth / 3);
  row.volume_error = row.removed_mm3 / cap_mm3 - 1;
  return row;
}

/// Engine and erosion.
std::vector<std::pair<std::string, ErosionMode>> sphere_programs(const Plan& plan) {
  std::vector<std::pair<std::string, ErosionMode>> out;
  for (const std::string& engine : plan.engines) {
    if (engine == "bricked" || engine == "exact") out.emplace_back("exact", ErosionMode::exact);
    if (engine != "exact") out.emplace_back(engine, ErosionMode::remove);
  }
  return out;
}

}  // namespace

void measure_spheres(const Plan& plan, const BenchControl& control, Findings& findings) {
  for (const double voxel_mm : plan.sphere_voxels_mm) {
    const FilledVoxmap bone = block(voxel_mm);
    const Tool tool = cap(voxel_mm);
    const BenchSetup setup{&bone, &tool, bone.grid.bounds_mm(), shell_box(tool)};
    for (const auto& [engine, erosion] : sphere_programs(plan)) {
      control.progress("plunged sphere, " + engine + ", " + name_of(erosion));
      const Place place{{engine, "deterministic"}, bone.grid.dims.x(), tool.shell.resolution, "sphere"};
      try {
        const auto program = make_engine_program(engine, plan.device, setup, erosion);
        findings.spheres.push_back(plunge(*program, erosion, voxel_mm, control));
      } catch (const InputError& error) {
        findings.skipped.push_back({place, error.what()});
      } catch (const RunError& error) {
        findings.skipped.push_back({place, error.what()});
      }
    }
  }
}

}  // namespace reamsim::bench
