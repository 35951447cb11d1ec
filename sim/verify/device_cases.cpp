// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// An OpenCL device: every engine and kernel shape against the serial reference, and how long frames take.
#include <fmt/core.h>
#include <algorithm>
#include <limits>

#include "sim/base/stopwatch.h"
#include "sim/bench/suite.h"
#include "sim/verify/suite.h"

namespace reamsim::verify {

namespace {

/// An engine with settings under which it must give the numbers of the serial reference.
struct Variant {
  const char* name = nullptr;
  EngineKind engine = EngineKind::exact;
  ErosionMode erosion = ErosionMode::exact;
  KernelShape shape = KernelShape::cpu;
  CuttingLaw law = CuttingLaw::energy;
  int work_group = 0;  ///< 0: that of the engine
};

/// The shell engines share one reference, so what holds for each of them holds between them.
constexpr Variant kVariants[] = {
    {"exact, CPU shape", EngineKind::exact, ErosionMode::exact, KernelShape::cpu},
    {"exact, GPU shape", EngineKind::exact, ErosionMode::exact, KernelShape::gpu},
    {"exact, GPU shape, groups of 64", EngineKind::exact, ErosionMode::exact, KernelShape::gpu, CuttingLaw::energy, 64},
    {"bricked, CPU shape", EngineKind::bricked, ErosionMode::remove, KernelShape::cpu},
    {"bricked, GPU shape", EngineKind::bricked, ErosionMode::remove, KernelShape::gpu},
    {"bricked, CPU shape, wear", EngineKind::bricked, ErosionMode::wear, KernelShape::cpu},
    {"bricked, GPU shape, wear", EngineKind::bricked, ErosionMode::wear, KernelShape::gpu},
    {"bricked, GPU shape, law per_point", EngineKind::bricked, ErosionMode::remove, KernelShape::gpu,
     CuttingLaw::per_point},
    {"direct", EngineKind::direct, ErosionMode::remove},
    {"direct, wear", EngineKind::direct, ErosionMode::wear},
    {"octree", EngineKind::octree, ErosionMode::remove},
    {"octree, law per_point", EngineKind::octree, ErosionMode::remove, KernelShape::cpu, CuttingLaw::per_point},
    {"implicit", EngineKind::implicit, ErosionMode::remove},
};

constexpr double kEngineVoxel_mm = 0.25, kPlungeDepth_mm = 1.5;
constexpr int kEngineFrames = 60;

/// Density without any order, and holes, by the place alone: threads sample it in any sequence.
double disordered_density(const Vec3& p) {
  const double noise = 43758.5453 * std::sin(p.dot(Vec3(12.9898, 78.233, 37.719)));
  return std::max(0.0, 2.5 * (noise - std::floor(noise)) - 0.6);
}

/// A tilted reamer on an oblique path through bone of all densities.
SimulationInput oblique_plunge(const Variant& variant, bool quick) {
  const double size = quick ? 8 : 12;
  const Quat turned = rotation({1, 2, 0.5}, 20);
  const Vec3 begin(0.4, -0.3, 1.2), end(-0.2, 0.5, -kPlungeDepth_mm);
  SimulationInput scene = scene_of(block({size, size, 4}, kEngineVoxel_mm, disordered_density),
                                   make_tool(convex_profile(5, 0.3 * size, 0.6, 2.5, 0.1), 0.5 * kEngineVoxel_mm),
                                   path(100, begin, {{end, kEngineFrames, 250, turned}}), variant.erosion);
  scene.scenario.engine.type = variant.engine;
  scene.scenario.engine.tuning.kernel_shape = variant.shape;
  scene.scenario.engine.tuning.work_group_size = variant.work_group;
  scene.scenario.cutting.law = variant.law;
  scene.scenario.cutting.wear_g_cm3_per_s = 30;
  return scene;
}

/// What differs between two runs of a scene.
struct Difference {
  int frames = 0;
  double force = 0;  ///< largest, of the peak force
  std::int64_t voxels = 0;
};

Difference difference_of(const Reamed& reference, const Reamed& other) {
  Difference out;
  double peak = 0, largest = 0;
  for (std::size_t k = 0; k < reference.rows.size(); ++k) {
    const FrameResult &a = reference.rows[k], &b = other.rows.at(k);
    const bool same = a.force_n == b.force_n && a.torque_nmm == b.torque_nmm && a.energy_mj == b.energy_mj &&
                      a.removed_mm3 == b.removed_mm3 && a.contacts == b.contacts;
    out.frames += same ? 0 : 1;
    peak = std::max(peak, a.force_n.norm());
    largest = std::max(largest, (a.force_n - b.force_n).norm());
  }
  const VoxelGrid& grid = reference.bone.voxmap->grid;
  for (std::int64_t e = 0; e < grid.size(); ++e) {
    out.voxels += reference.bone.fill.get(grid.coord(e)) != other.bone.fill.get(grid.coord(e)) ? 1 : 0;
  }
  out.force = largest / peak;
  return out;
}

}  // namespace

void engines_case(const Setting& setting, Report& out) {
  out.title = "Engines and kernels against the serial reference";
  out.scene = fmt::format("tilted reamer on an oblique path through {:g} mm voxels of disordered density, {} frames",
                          kEngineVoxel_mm, kEngineFrames);
  out.form = "the same numbers and voxels; forces to 10⁻⁶ of the peak where the device does not round division";
  const bool exact = cl::choose_device(setting.device).rounds_division;
  Setting serial = setting;
  serial.device = "serial";
  double least_mm3 = std::numeric_limits<double>::infinity();
  for (const Variant& variant : kVariants) {
    const Reamed reference = ream(oblique_plunge(variant, setting.quick), serial);
    const Stopwatch watch;
    const Reamed found = ream(oblique_plunge(variant, setting.quick), setting);
    const double seconds = watch.seconds();
    const Difference difference = difference_of(reference, found);
    const std::string name = variant.name;
    if (exact) {
      const auto differ = static_cast<double>(difference.frames + difference.voxels);
      out.absolute(name + ": frames and voxels that differ", "", 0, differ, 0, "sums are integers");
    } else {
      out.at_most(name + ": largest difference of force over the peak", "", 1e-6, difference.force);
      out.reported(name + ": voxels that differ", "", static_cast<double>(difference.voxels));
    }
    out.reported(name + ": run time with the first compilation of kernels", "s", seconds);
    least_mm3 = std::min(least_mm3, found.removed_mm3());
  }
  out.at_least("least volume that one of them removed", "mm³", 1, least_mm3, "they remove bone");
}

void speed_case(const Setting& setting, Report& out) {
  out.title = "Speed";
  out.scene = "the paper's cap in a voxmap and shell of 512³; the plunged sphere; single frames of a steady plunge";
  out.form = "none; not comparable with the paper's 0.76 to 0.81 ms (GTX 970, shell of 1024³)";
  const auto median = [&](const std::string& name, const bench::Json& row) {
    out.reported(name + ", median", "ms", row["median_ms"].get<double>());
  };
  bench::Plan plan{.device = setting.device,
                   .engines = {"exact", "bricked", "direct"},
                   .sizes = {{512, 512}},
                   .repetitions = 3,
                   .verify_poses = false,
                   .details = false,
                   .sphere_voxels_mm = {0.25}};
  const bench::Json report = bench::run_bench(plan, {.stop = setting.stop});
  for (const bench::Json& row : report["results"]) {
    median(fmt::format("{}, {}", bench::name_of({row["engine"], row["variant"]}), row["case"].get<std::string>()), row);
  }
  for (const bench::Json& skipped : report["skipped"]) out.form += "; not measured: " + skipped.dump();
  for (const bench::Json& row : report["spheres"])
    median(row["engine"].get<std::string>() + ", sphere of 0.25 mm", row);
  SimulationInput plunge = scene_of(block({34, 34, 8}, 0.25, kExample.density_g_cm3), make_tool(head_of(kExample)),
                                    path(1000, {0, 0, 0.1}, {{{0, 0, -4}, 4000, kExample.rpm}}));
  plunge.scenario.engine.device = setting.device;
  const auto engine = make_engine(plunge.scenario, plunge.bone, plunge.tool);
  const bench::Latency latency = bench::frame_latency(plunge, *engine, 2000, setting.stop);
  out.reported("exact, a frame alone, median", "ms", latency.median_ms);
  out.reported("exact, a frame alone, 99 % of frames", "ms", latency.p99_ms);
  out.at_least("frames in contact", "", 100, static_cast<double>(latency.frames), "enough for percentiles");
}

}  // namespace reamsim::verify
