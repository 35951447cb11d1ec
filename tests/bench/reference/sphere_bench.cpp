// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/bench/reference/sphere_bench.h"

#include <benchmark/benchmark.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <thread>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/bench/scene.h"
#include "sim/engine/common/engine.h"
#include "sim/engine/common/substep.h"
#include "tests/bench/reference/exact.h"

namespace reamsim::reference {

namespace {

constexpr double kVoxelsMm[] = {0.25, 0.1, 0.04};
constexpr int kDepths = 4;       // at which frames are timed
constexpr int kRuns = 5;         // of each program at each depth
constexpr int kRunFrames = 256;  // four windows of smooth motion
constexpr std::int64_t kAligned = 64;
constexpr double kStepVoxels = 0.25;  // of the way from one depth to the next
constexpr double kFrameMm = bench::kSphereFeedMmS * bench::kSphereFrameS;
constexpr const char* kEngine = "exact";

/// The scene of a voxel size, and how a program takes frames through it.
class SphereScene {
 public:
  explicit SphereScene(double voxel_mm) : bone_(bench::sphere_block(voxel_mm)), tool_(bench::sphere_cap(voxel_mm)) {
    cutting_ = bench::bench_cutting();
    cutting_.erosion = ErosionMode::exact;
  }

  [[nodiscard]] double voxel_mm() const { return bone_.grid.voxel_mm; }
  [[nodiscard]] std::unique_ptr<Engine> engine() const {
    Scenario scenario;
    scenario.name = "reference";
    scenario.engine.type = EngineKind::exact;
    scenario.cutting = cutting_;
    return make_engine(scenario, bone_, tool_);
  }
  [[nodiscard]] std::unique_ptr<Engine> reference(Target target) const {
    return std::make_unique<ExactReference>(bone_, tool_, cutting_, target, std::thread::hardware_concurrency());
  }

  /// The sums of consecutive frames: broad phase, arguments, windows, visits, and the sums read.
  std::vector<SubstepSums> run(Engine& engine, const std::vector<Substep>& frames) const {
    const std::int64_t first = frames.front().frame;
    const auto args_of = [&](std::int64_t frame) -> std::optional<SubstepArgs> {
      if (frame < first) return std::nullopt;
      return args(frames[static_cast<std::size_t>(frame - first)], tool_box_);
    };
    MotionWindows windows(args_of, frames.back().frame, tool_box_);
    for (const Substep& frame : frames) {
      const auto voi = broad_phase(tool_box_, bone_box_, frame.pose.bone_from_tool().inverse());
      if (voi) engine.enqueue(args(frame, *voi), windows.of(frame.frame));
    }
    return engine.collect().sums;
  }

 private:
  [[nodiscard]] SubstepArgs args(const Substep& frame, const Aabb& voi) const {
    return make_args(frame, voi, tool_.shell, bone_.grid, cutting_, false);
  }

  FilledVoxmap bone_;
  Tool tool_;
  CuttingSettings cutting_;
  Aabb bone_box_ = bone_.grid.bounds_mm();
  Aabb tool_box_ = bench::shell_box(tool_);
};

/// A program, and its times so far, ms per frame.
struct SphereProgram {
  std::string name;
  std::unique_ptr<Engine> engine;
  std::vector<double> ms;
};

std::vector<SphereProgram> make_programs(const SphereScene& scene) {
  std::vector<SphereProgram> out;
  out.push_back({kEngine, scene.engine(), {}});
  for (const Target target : usable_targets()) out.push_back({name_of(target), scene.reference(target), {}});
  return out;
}

bool same_bytes(const std::vector<SubstepSums>& a, const std::vector<SubstepSums>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), sizeof(SubstepSums) * a.size()) == 0;
}

/// Runs the frames with each program in turn, and records their times where `timed`. Throws RunError where their
/// sums differ.
void run_in_turn(const SphereScene& scene, const std::vector<Substep>& frames, bool timed,
                 std::vector<SphereProgram>& programs) {
  std::vector<SubstepSums> expected;
  for (SphereProgram& program : programs) {
    const Stopwatch watch;
    std::vector<SubstepSums> sums = scene.run(*program.engine, frames);
    const double seconds = watch.seconds();
    if (timed) program.ms.push_back(1e3 * seconds / static_cast<double>(frames.size()));
    if (expected.empty())
      expected = std::move(sums);
    else if (!same_bytes(sums, expected))
      throw RunError(program.name + " differs from " + kEngine);
  }
}

/// Takes all programs through the plunge. Frames are timed at the true feed rate, and the way between is made in steps.
void measure_plunge(const SphereScene& scene, std::vector<SphereProgram>& programs) {
  double depth = 0;
  for (int i = 1; i <= kDepths; ++i) {
    const auto last = std::lround(bench::kSphereDepthMm * i / kDepths / kFrameMm / kAligned) * kAligned;
    std::int64_t first = last - kRuns * kRunFrames;
    for (const double begin = static_cast<double>(first) * kFrameMm; depth < begin;) {
      depth = std::min(begin, depth + kStepVoxels * scene.voxel_mm());
      run_in_turn(scene, {bench::sphere_frame(depth, 0)}, false, programs);
    }
    for (; first < last; first += kRunFrames) {
      std::vector<Substep> frames;
      for (std::int64_t k = first; k < first + kRunFrames; ++k)
        frames.push_back(bench::sphere_frame(static_cast<double>(k) * kFrameMm, k));
      run_in_turn(scene, frames, true, programs);
    }
    depth = static_cast<double>(last - 1) * kFrameMm;
  }
}

double median_of(std::vector<double> values) {
  std::ranges::sort(values);
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

/// The median over the runs of how many times as long `a` takes as `b`. Runs are alternated, so that their ratio
/// depends less on what else the machine does than their times.
double median_ratio(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < a.size(); ++i) ratios.push_back(a[i] / b[i]);
  return median_of(std::move(ratios));
}

}  // namespace

struct SphereBench::Size {
  double voxel_mm = 0;
  std::map<std::string, std::vector<double>> ms;  ///< per frame, by program

  [[nodiscard]] std::string name() const { return fmt::format("sphere_{}", voxel_mm); }

  void measure() {
    if (!ms.empty()) return;
    const SphereScene scene(voxel_mm);
    std::vector<SphereProgram> programs = make_programs(scene);
    measure_plunge(scene, programs);
    for (SphereProgram& program : programs) ms[program.name] = std::move(program.ms);
  }
};

SphereBench::SphereBench() {
  for (const double voxel_mm : kVoxelsMm) {
    sizes_.push_back(std::make_unique<Size>());
    sizes_.back()->voxel_mm = voxel_mm;
  }
}

SphereBench::~SphereBench() = default;

void SphereBench::register_rows() {
  std::vector<std::string> programs{kEngine};
  for (const Target target : usable_targets()) programs.emplace_back(name_of(target));
  for (const auto& size : sizes_) {
    for (const std::string& program : programs) {
      const auto row = [program, at = size.get()](benchmark::State& state) {
        at->measure();
        std::size_t run = 0;
        for (auto _ : state) state.SetIterationTime(1e-3 * at->ms.at(program).at(run++));
      };
      benchmark::RegisterBenchmark((size->name() + "/" + program).c_str(), row)
          ->Iterations(kDepths * kRuns)
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
}

void SphereBench::print_ratios() const {
  for (const auto& size : sizes_) {
    if (size->ms.empty()) continue;
    const std::vector<double>& engine = size->ms.at(kEngine);
    std::printf("%-11s %s %.4f (%.4f)", size->name().c_str(), kEngine, median_of(engine), std::ranges::min(engine));
    for (const auto& [name, ms] : size->ms) {
      if (name == kEngine) continue;
      std::printf("   %s %.4f (%.4f) %.2fx", name.c_str(), median_of(ms), std::ranges::min(ms),
                  median_ratio(engine, ms));
    }
    std::printf("\n");
  }
}

}  // namespace reamsim::reference
