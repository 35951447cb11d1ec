// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sim/bench/scene.h"
#include "sim/bench/suite.h"
#include "sim/device/opencl.h"
#include "sim/engine/common/engine.h"
#include "sim/engine/common/substep.h"

namespace reamsim::bench {

/// The bone, the tool and their boxes. The caller owns voxmap and tool.
struct BenchSetup {
  const FilledVoxmap* voxmap = nullptr;
  const Tool* tool = nullptr;
  Aabb bone_box;  ///< B, mm
  Aabb tool_box;  ///< T, mm
};

/// Times and results of a batch of frames; seconds of wall time unless stated otherwise.
struct BatchSample {
  double total_s = 0;         ///< broad phase, arguments, kernels and results read
  double upload_s = 0;        ///< of the total: arguments computed and sent, kernels enqueued
  double kernel_s = 0;        ///< of the total: kernels, by the clock of the device
  std::int64_t voxels = 0;    ///< that lost bone; 0 where the program does not count them
  double removed = 0;         ///< removed voxels, partial ones as fractions; 0 where the program does not count them
  std::int64_t contacts = 0;  ///< touching points, of a published program that counts them
  Vec3 force = Vec3::Zero();  ///< an engine: N, in T; a published program: elemental forces, in B
};

/// A program that detects contact and removes bone. Frames change its bone until restore().
class Program {
 public:
  Program(Label label, const BenchSetup& setup) : label_(std::move(label)), setup_(setup) {}
  virtual ~Program() = default;
  /// Runs substeps as frames, enqueued at once where the program can, and reads their results. `use_voi` false: tests
  /// the whole shell.
  virtual BatchSample run(std::span<const Substep> frames, bool use_voi) = 0;
  /// Restores the bone. Not timed.
  virtual void restore() = 0;
  [[nodiscard]] virtual StructureBytes bytes() const = 0;
  [[nodiscard]] const Label& label() const { return label_; }

 protected:
  Label label_;
  BenchSetup setup_;
};

/// An engine of `erosion: remove`, or the published program of one: that of `direct` counts contacts where `count` says
/// so, with one more atomic sum per point; that of `octree` always does, and needs a cube of 2^n voxels along each
/// edge. Throws what make_engine() throws, RunError when the device has not enough memory.
std::unique_ptr<Program> make_program(const Label& label, const std::string& device, const BenchSetup& setup,
                                      bool count = false);

/// A row with the keys of a case: program, sizes and case (severe | light | none | plunge). `implicit` has no shell;
/// its rows have the largest.
Json case_row(const Label& who, const SizePair& size, const std::string& contact);
/// The keys median_ms, min_ms and max_ms.
Json spread_ms(const Spread& ms);
/// Adds the results of a case to the report: touching points, mean over the poses (plunge, implicit and exact: voxels
/// per frame; null: not known), host wall time and median device time of a frame, and the median of published `direct`
/// over this one, if that was measured.
Json& add_result(Json row, const Json& contacts, const Spread& ms, double kernel_ms, Json& report);

/// Calls `measure`; where the device cannot do it (InputError, RunError, no memory), lists the case with the reason.
void measure_or_skip(Json row, Json& report, const std::function<void()>& measure);

using Programs = std::vector<std::shared_ptr<Program>>;

/// The programs of one setup, and what the parts of the benchmark share.
struct ProgramSet {
  const Plan& plan;
  const BenchControl& control;
  Json& report;
  BenchSetup setup;
  SizePair size;
  Programs programs;

  [[nodiscard]] Json row(const Program& program, const std::string& contact) const {
    return case_row(program.label(), size, contact);
  }
};

/// Adds every program of the plan's engines in all its variants that the device can hold. `whole`: also engines without
/// a shell.
void make_programs(ProgramSet& set, bool whole);

/// Runs the frames one by one, each program in turn, `repetitions` times in two rounds, each after a warm-up: a frame
/// follows one at the same place, as in a run, where caches hold the data near the tool. Returns samples by program.
/// Throws Interrupted.
std::vector<std::vector<BatchSample>> run_alternately(const Programs& programs, const std::vector<Substep>& frames,
                                                      int repetitions, bool use_voi, const BenchControl& control);

/// Median and spread over samples; `scale`: s to ms by default.
template <class Value>
Spread spread_over(const std::vector<BatchSample>& samples, Value BatchSample::*member, double scale = 1e3) {
  std::vector<double> values;
  for (const BatchSample& sample : samples) values.push_back(scale * static_cast<double>(sample.*member));
  return spread_of(values);
}

/// Adds the device memory of an engine, unless it is known.
void add_memory(const std::string& engine, const SizePair& size, const StructureBytes& bytes, Json& report);

// The parts of the benchmark; each adds its rows to the report.
void measure_case(const ProgramSet& set, Contact contact);
void measure_voi(const ProgramSet& set);
void measure_batches(const ProgramSet& set);
void measure_plunge(const ProgramSet& set);
void measure_scatter(const ProgramSet& set);
/// Without contact: the plunge.
void measure_exact_case(const ProgramSet& set, std::optional<Contact> contact);
/// Calls `begin` before each sphere.
void measure_spheres(const Plan& plan, const BenchControl& control,
                     const std::function<void(const std::string&)>& begin, Json& report);

/// What a device does at most, as the report has it: 10⁹ operations a second in single precision, a fused multiply-add
/// as two, in registers; 10⁹ bytes a second, read and written, of a copy of 256 MB. The best of some repetitions.
Json measure_peaks(const cl::DeviceInfo& info);

}  // namespace reamsim::bench
