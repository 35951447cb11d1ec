#include <algorithm>

#include "sim/base/stopwatch.h"
#include "sim/bench/contender.h"
#include "sim/bench/poses.h"
#include "sim/engine/make_engine.h"

namespace reamsim::bench {

namespace {

class EngineContender final : public Contender {
 public:
  EngineContender(const std::string& engine, const std::string& device, const Arena& arena,
                  const CuttingSettings& cutting)
      : arena_(arena),
        cutting_(cutting),
        label_{engine, "deterministic"},
        engine_(make_engine(settings(engine, device, cutting), *arena.voxmap, *arena.tool)) {}

  BatchSample run(std::span<const Substep> frames, bool use_voi) override {
    BatchSample sample;
    const Stopwatch watch;
    for (const Substep& frame : frames) enqueue(frame, use_voi, sample);
    collect(sample);
    sample.total_s = watch.seconds();
    keep_removed();  // bookkeeping of the benchmark
    return sample;
  }

  void restore() override {
    engine_->restore_voxels(*arena_.voxmap, removed_);
    removed_.clear();
  }

  [[nodiscard]] StructureBytes bytes() const override { return engine_->structure_bytes(); }
  [[nodiscard]] const Label& label() const override { return label_; }

 private:
  static Scenario settings(const std::string& engine, const std::string& device, const CuttingSettings& cutting) {
    Scenario scenario;
    scenario.name = "bench";
    scenario.engine.type = *from_name<EngineKind>(engine);
    scenario.engine.device = device;
    scenario.cutting = cutting;
    return scenario;
  }

  void enqueue(const Substep& frame, bool use_voi, BatchSample& sample) {
    const Stopwatch broad;
    const auto voi = broad_phase(arena_.tool_box, arena_.bone_box, frame.pose.bone_from_tool().inverse());
    sample.broad_s += broad.seconds();
    if (!voi) return;
    if (engine_->full()) {
      collect(sample);
      keep_removed();
    }
    const Stopwatch upload;
    const VoxelGrid& grid = arena_.voxmap->grid;
    engine_->enqueue(use_voi ? make_args(frame, *voi, arena_.tool->shell, grid, cutting_, false)
                             : args_without_voi(frame, *arena_.tool, grid));
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

  Arena arena_;
  CuttingSettings cutting_;
  Label label_;
  std::unique_ptr<Engine> engine_;
  RemovedFrames removed_;  ///< since the bone was whole
};

}  // namespace

std::unique_ptr<Contender> make_engine_contender(const std::string& engine, const std::string& device,
                                                 const Arena& arena, ErosionMode erosion) {
  CuttingSettings cutting = bench_cutting();
  cutting.erosion = erosion;
  return std::make_unique<EngineContender>(engine, device, arena, cutting);
}

}  // namespace reamsim::bench
