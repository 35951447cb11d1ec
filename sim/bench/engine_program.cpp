// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>

#include "sim/base/stopwatch.h"
#include "sim/bench/poses.h"
#include "sim/bench/program.h"
#include "sim/engine/make_engine.h"

namespace reamsim::bench {

namespace {

class EngineProgram final : public Program {
 public:
  EngineProgram(const std::string& engine, const std::string& device, const BenchSetup& setup)
      : setup_(setup),
        label_{engine, "deterministic"},
        engine_(make_engine(settings(engine, device), *setup.voxmap, *setup.tool)) {}

  BatchSample run(std::span<const Substep> frames, bool use_voi) override {
    BatchSample sample;
    const Stopwatch stopwatch;
    for (const Substep& frame : frames) enqueue(frame, use_voi, sample);
    collect(sample);
    sample.total_s = stopwatch.seconds();
    keep_removed();  // bookkeeping of the benchmark
    return sample;
  }

  void restore() override {
    engine_->restore_voxels(*setup_.voxmap, removed_);
    removed_.clear();
  }

  [[nodiscard]] StructureBytes bytes() const override { return engine_->structure_bytes(); }
  [[nodiscard]] const Label& label() const override { return label_; }

 private:
  static Scenario settings(const std::string& engine, const std::string& device) {
    Scenario scenario;
    scenario.name = "bench";
    scenario.engine.type = *from_name<EngineKind>(engine);
    scenario.engine.device = device;
    scenario.cutting = bench_cutting();
    return scenario;
  }

  void enqueue(const Substep& frame, bool use_voi, BatchSample& sample) {
    const Stopwatch broad;
    const auto voi = broad_phase(setup_.tool_box, setup_.bone_box, frame.pose.bone_from_tool().inverse());
    sample.broad_s += broad.seconds();
    if (!voi) return;
    if (engine_->full()) {
      collect(sample);
      keep_removed();
    }
    const Stopwatch upload;
    const VoxelGrid& grid = setup_.voxmap->grid;
    engine_->enqueue(use_voi ? make_args(frame, *voi, setup_.tool->shell, grid, bench_cutting(), false)
                             : args_without_voi(frame, *setup_.tool, grid),
                     nullptr);
    sample.upload_s += upload.seconds();
  }

  void collect(BatchSample& sample) {
    const Batch batch = engine_->collect();
    for (const StageTimes& times : batch.times) sample.kernel_s += times.detect_s + times.cut_s;
    for (const SubstepSums& sums : batch.sums) {
      sample.voxels += sums.contacts;
      sample.removed += static_cast<double>(sums.removed) / RS_WHOLE_FILL;
      for (int i = 0; i < 3; ++i) sample.force[i] += static_cast<double>(sums.force[i]) / RS_FORCE_SCALE;
    }
  }

  void keep_removed() {
    const RemovedFrames removed = engine_->take_removed();
    removed_.insert(removed_.end(), removed.begin(), removed.end());
  }

  BenchSetup setup_;
  Label label_;
  std::unique_ptr<Engine> engine_;
  RemovedFrames removed_;  ///< since the bone was whole
};

}  // namespace

std::unique_ptr<Program> make_engine_program(const std::string& engine, const std::string& device,
                                             const BenchSetup& setup) {
  return std::make_unique<EngineProgram>(engine, device, setup);
}

}  // namespace reamsim::bench
