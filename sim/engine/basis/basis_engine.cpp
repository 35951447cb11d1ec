// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/engines.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "sim/base/parallel.h"
#include "sim/engine/basis/exact_basis.h"
#include "sim/engine/common/tables.h"
#include "sim/tool/tool.h"

namespace reamsim {

namespace {

/// The force basis of `erosion: remove`, from the voxels that the engine removed.
class TouchedBasis {
 public:
  /// The voxmap must outlive it.
  TouchedBasis(const BoneView& bone, const Tool& tool)
      : voxmap_(&bone.voxmap), outline_(make_outline_table(tool.profile, bone.voxmap.grid.voxel_mm)) {}

  /// The basis of each substep. `removed`: voxels, and the places in `args` of the substeps that removed them.
  [[nodiscard]] std::vector<SubstepBasis> of(std::span<const SubstepArgs> args, const RemovedFrames& removed) const;

 private:
  [[nodiscard]] BasisValues response(const UnitArgs& args, const Vec3i& voxel) const;

  const Voxmap* voxmap_;
  OutlineTable outline_;
};

/// As rs_voxel_force().
BasisValues TouchedBasis::response(const UnitArgs& args, const Vec3i& voxel) const {
  const OutlineView outline = view_of(outline_);
  const SubstepArgs& a = args.without_normal;
  BrickMiddle brick;
  rs_brick_in_tool(&a, voxel.x(), voxel.y(), voxel.z(), &brick);
  Clip clip{};
  rs_voxel_in_tool(&a, &brick, static_cast<float>(voxel.x() & 7), static_cast<float>(voxel.y() & 7),
                   static_cast<float>(voxel.z() & 7), clip.p);
  const float r = RS_SQRT(clip.p[0] * clip.p[0] + clip.p[1] * clip.p[1]);
  rs_outline_normal(&outline, rs_pieces_near(&outline, r, clip.p[2]), clip.p, clip.n);
  return unit_response(args, clip, static_cast<float>(voxmap_->grid.voxel_mm3()));
}

std::vector<SubstepBasis> TouchedBasis::of(std::span<const SubstepArgs> args, const RemovedFrames& removed) const {
  RemovedFrames ordered = removed;
  std::ranges::sort(ordered, {}, [](const auto& voxel) { return std::pair(voxel.second, voxel.first); });
  std::vector<SubstepBasis> out(args.size());
  parallel_items(args.size(), [&](std::size_t slot) {
    const auto slot_of = [](const auto& voxel) { return voxel.second; };
    const auto begin = std::ranges::lower_bound(ordered, static_cast<std::int32_t>(slot), {}, slot_of);
    const auto end = std::ranges::upper_bound(begin, ordered.end(), static_cast<std::int32_t>(slot), {}, slot_of);
    if (begin == end) return;
    const UnitArgs units(args[slot], 0);
    BrickBasis sums(1);
    for (auto at = begin; at != end; ++at) {
      const Vec3i voxel = voxmap_->grid.coord(at->first);
      sums.add(0, voxmap_->grade.get(voxel), RS_WHOLE_FILL, response(units, voxel));
    }
    VisitBasis whole(1);
    whole.add(sums);
    out[slot] = std::move(whole.substeps().front());
  });
  return out;
}

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
