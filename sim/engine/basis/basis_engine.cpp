// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/basis/basis_engine.h"

#include <optional>
#include <utility>

#include "sim/engine/basis/exact_basis.h"
#include "sim/engine/basis/touched_basis.h"

namespace reamsim {

namespace {

/// `erosion: exact`: the basis is found apart from the engine.
class ExactBasisEngine final : public Engine {
 public:
  ExactBasisEngine(std::unique_ptr<Engine> engine, const Scenario& scenario, const BoneView& bone, const Tool& tool)
      : engine_(std::move(engine)), scenario_(scenario), tool_(&tool), basis_(scenario, bone, tool) {}

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) override {
    args_.push_back(args);
    motions_.push_back(window);
    engine_->enqueue(args, std::move(window));
  }
  [[nodiscard]] bool full() const override { return engine_->full(); }
  Batch collect() override {
    Batch out = engine_->collect();
    out.basis = basis_.cut(args_, motions_);
    args_.clear();
    motions_.clear();
    return out;
  }
  RemovedFrames take_removed() override { return engine_->take_removed(); }
  void read_fill(const Voxmap& voxmap, FillBricks& fill) override { engine_->read_fill(voxmap, fill); }
  void restore(const BoneView& bone) override {
    engine_->restore(bone);
    basis_ = ExactBasis(scenario_, bone, *tool_);
  }
  [[nodiscard]] std::string device() const override { return engine_->device(); }
  [[nodiscard]] std::size_t device_bytes() const override { return engine_->device_bytes(); }
  [[nodiscard]] StructureBytes structure_bytes() const override { return engine_->structure_bytes(); }

 private:
  std::unique_ptr<Engine> engine_;
  Scenario scenario_;
  const Tool* tool_;
  ExactBasis basis_;
  std::vector<SubstepArgs> args_;  ///< of the batch
  MotionsOfSlots motions_;
};

/// `erosion: remove`. The engine gets the place of a substep in the batch as its frame, and so tells which substep
/// removed a voxel.
class TouchedBasisEngine final : public Engine {
 public:
  TouchedBasisEngine(std::unique_ptr<Engine> engine, const BoneView& bone, const Tool& tool)
      : engine_(std::move(engine)), basis_(bone, tool) {}

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) override {
    SubstepArgs placed = args;
    placed.frame = static_cast<std::int32_t>(args_.size());
    args_.push_back(args);
    engine_->enqueue(placed, std::move(window));
  }
  [[nodiscard]] bool full() const override { return engine_->full(); }
  Batch collect() override {
    Batch out = engine_->collect();
    removed_ = engine_->take_removed();
    out.basis = basis_.of(args_, removed_);
    for (auto& [voxel, place] : removed_) place = args_[static_cast<std::size_t>(place)].frame;
    args_.clear();
    return out;
  }
  RemovedFrames take_removed() override { return std::exchange(removed_, {}); }
  void read_fill(const Voxmap& voxmap, FillBricks& fill) override { engine_->read_fill(voxmap, fill); }
  void restore(const BoneView& bone) override { engine_->restore(bone); }
  [[nodiscard]] std::string device() const override { return engine_->device(); }
  [[nodiscard]] std::size_t device_bytes() const override { return engine_->device_bytes(); }
  [[nodiscard]] StructureBytes structure_bytes() const override { return engine_->structure_bytes(); }

 private:
  std::unique_ptr<Engine> engine_;
  TouchedBasis basis_;
  std::vector<SubstepArgs> args_;  ///< of the batch
  RemovedFrames removed_;
};

}  // namespace

std::unique_ptr<Engine> make_basis_engine(std::unique_ptr<Engine> engine, const Scenario& scenario,
                                          const BoneView& bone, const Tool& tool) {
  if (scenario.cutting.erosion == ErosionMode::exact)
    return std::make_unique<ExactBasisEngine>(std::move(engine), scenario, bone, tool);
  return std::make_unique<TouchedBasisEngine>(std::move(engine), bone, tool);
}

}  // namespace reamsim
