// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The engines against the same frames in C++ without OpenCL. `bricked` at 1024³ × 1024³: severe contact, light contact,
// none. A frame is broad phase, arguments, narrow phase, cut, and the sums read; the bone is restored after it, which
// is not timed. `exact` on the plunged sphere: see sphere_bench.h.
//
//   reference_bench [--benchmark_min_time=S] [--benchmark_filter=severe|sphere]
//
// Checks that both compute the same to the last bit. Ends with medians and their ratio; status 1 where they differ.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <thread>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/bench/scene.h"
#include "sim/engine/common/engine.h"
#include "sim/engine/common/substep.h"
#include "tests/bench/reference/reference.h"
#include "tests/bench/reference/sphere_bench.h"

namespace reamsim::reference {
namespace {

using bench::Contact;

constexpr int kSide = 1024;
constexpr const char* kBricked = "bricked";
/// Read before every frame, so that none finds its bone in the cores' own caches because of how it was put back.
constexpr std::size_t kSweepBytes = 16 << 20;

struct Arena {
  bench::BoneSeries series{256};
  FilledVoxmap bone = series.at(kSide);
  Tool tool = bench::cap_tool(kSide);
  Aabb bone_box = series.box(kSide);
  Aabb tool_box = bench::shell_box(tool);
};

/// One of the two programs.
class Program {
 public:
  explicit Program(const Arena& arena) : arena_(arena) {}
  virtual ~Program() = default;
  virtual SubstepSums collide_and_cut(const SubstepArgs& args) = 0;
  virtual std::vector<std::int64_t> take_removed() = 0;
  virtual void restore() = 0;

  SubstepSums frame(const Substep& substep) {
    const auto voi = broad_phase(arena_.tool_box, arena_.bone_box, substep.pose.bone_from_tool().inverse());
    if (!voi) return {};
    return collide_and_cut(
        make_args(substep, *voi, arena_.tool.shell, arena_.bone.grid, bench::bench_cutting(), false));
  }

 protected:
  const Arena& arena_;
};

class CppProgram final : public Program {
 public:
  CppProgram(const Arena& arena, Target target)
      : Program(arena),
        reference_(arena.bone, arena.tool, bench::bench_cutting(), target, std::thread::hardware_concurrency()) {}
  SubstepSums collide_and_cut(const SubstepArgs& args) override { return reference_.run(args); }
  std::vector<std::int64_t> take_removed() override { return reference_.removed_voxels(); }
  void restore() override { reference_.restore(); }

 private:
  Reference reference_;
};

class BrickedProgram final : public Program {
 public:
  explicit BrickedProgram(const Arena& arena)
      : Program(arena), engine_(make_engine(settings(), arena.bone, arena.tool)) {}
  SubstepSums collide_and_cut(const SubstepArgs& args) override {
    engine_->enqueue(args);
    return engine_->collect().sums.front();
  }
  std::vector<std::int64_t> take_removed() override {
    removed_ = engine_->take_removed();
    std::vector<std::int64_t> out;
    for (const auto& [voxel, frame] : removed_) out.push_back(voxel);
    std::sort(out.begin(), out.end());
    return out;
  }
  void restore() override {
    const RemovedFrames late = engine_->take_removed();  // empty after take_removed()
    engine_->restore_voxels(arena_.bone, late.empty() ? removed_ : late);
    removed_.clear();
  }
  [[nodiscard]] std::string device() const { return engine_->device(); }

 private:
  static Scenario settings() {
    Scenario scenario;
    scenario.name = "reference";
    scenario.engine.type = EngineKind::bricked;
    scenario.cutting = bench::bench_cutting();
    return scenario;
  }

  std::unique_ptr<Engine> engine_;
  RemovedFrames removed_;
};

/// Throws RunError where two programs do not give the same sums and take the same voxels.
void check_agreement(Program& expected, Program& program, const std::string& name) {
  for (const Contact contact : bench::kContacts) {
    for (const Substep& substep : bench::substeps_of(contact)) {
      const SubstepSums a = expected.frame(substep), b = program.frame(substep);
      const bool same = std::memcmp(&a, &b, sizeof a) == 0 && expected.take_removed() == program.take_removed();
      expected.restore();
      program.restore();
      if (!same) throw RunError(name + " differs from bricked in case " + bench::name_of(contact));
    }
  }
}

void sweep_caches() {
  static std::vector<std::uint64_t> memory(kSweepBytes / sizeof(std::uint64_t), 1);
  std::uint64_t sum = 0;
  for (const std::uint64_t word : memory) sum += word;
  benchmark::DoNotOptimize(sum);
}

/// Milliseconds per frame, by case and program.
using Times = std::map<std::pair<std::string, std::string>, std::vector<double>>;

/// An iteration is a frame on each approach; its time is their mean.
void measure(benchmark::State& state, Program& program, Contact contact, std::vector<double>& times) {
  const std::vector<Substep> substeps = bench::substeps_of(contact);
  SubstepSums sums{};
  for (auto _ : state) {
    double seconds = 0;
    for (const Substep& substep : substeps) {
      sweep_caches();
      const Stopwatch watch;
      sums = program.frame(substep);
      seconds += watch.seconds() / static_cast<double>(substeps.size());
      program.restore();
    }
    state.SetIterationTime(seconds);
    times.push_back(1e3 * seconds);
  }
  state.counters["voxels"] = static_cast<double>(sums.contacts);
}

struct Spread {
  double lowest = 0, median = 0;
};

Spread spread_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {values.front(), (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2};
}

/// The lowest are printed too, because other programs on the machine only ever add.
void print_ratios(const Times& times) {
  for (const Contact contact : bench::kContacts) {
    const std::string name = bench::name_of(contact);
    const auto found = times.find({name, kBricked});
    if (found == times.end() || found->second.empty()) continue;
    const Spread bricked = spread_of(found->second);
    std::printf("%-7s bricked %.3f (%.3f)", name.c_str(), bricked.median, bricked.lowest);
    for (const auto& [key, values] : times) {
      if (key.first != name || key.second == kBricked || values.empty()) continue;
      const Spread other = spread_of(values);
      std::printf("   %s %.3f (%.3f) %.2fx (%.2fx)", key.second.c_str(), other.median, other.lowest,
                  bricked.median / other.median, bricked.lowest / other.lowest);
    }
    std::printf("\n");
  }
}

/// The programs, made when the first benchmark runs.
class BrickedBench {
 public:
  void register_rows() {
    for (const Contact contact : bench::kContacts) {
      for (const Target target : usable_targets()) register_row(contact, name_of(target));
      register_row(contact, kBricked);
    }
  }
  void print() const { print_ratios(times_); }

 private:
  void register_row(Contact contact, const std::string& name) {
    const std::string label = bench::name_of(contact);
    const auto row = [this, contact, name, label](benchmark::State& state) {
      if (programs_.empty()) make_programs();
      measure(state, *programs_.at(name), contact, times_[{label, name}]);
    };
    benchmark::RegisterBenchmark((label + "/" + name).c_str(), row)->UseManualTime()->Unit(benchmark::kMillisecond);
  }

  void make_programs() {
    arena_ = std::make_unique<Arena>();
    auto bricked = std::make_unique<BrickedProgram>(*arena_);
    std::printf("bricked on %s; C++ on %u threads\n", bricked->device().c_str(), std::thread::hardware_concurrency());
    for (const Target target : usable_targets()) {
      auto program = std::make_unique<CppProgram>(*arena_, target);
      check_agreement(*bricked, *program, name_of(target));
      programs_[name_of(target)] = std::move(program);
    }
    programs_[kBricked] = std::move(bricked);
    std::printf("sums and voxels agree to the last bit in every case\n");
  }

  std::unique_ptr<Arena> arena_;
  std::map<std::string, std::unique_ptr<Program>> programs_;
  Times times_;
};

int run() {
  BrickedBench bricked;
  SphereBench spheres;
  bricked.register_rows();
  spheres.register_rows();
  benchmark::RunSpecifiedBenchmarks();
  std::printf("\nms per frame, median (lowest); x: how many times as long the engine takes\n");
  bricked.print();
  spheres.print_ratios();
  return 0;
}

}  // namespace
}  // namespace reamsim::reference

int main(int argc, char** argv) {
  // As the program itself does, before OpenCL loads.
  setenv("POCL_AFFINITY", "1", 0);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  try {
    return reamsim::reference::run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "reference_bench: error: %s\n", error.what());
    return 1;
  }
}
