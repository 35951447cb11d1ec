#include "sim/engine/dense/dense_engine.h"

#include <algorithm>
#include <bit>

#include "sim/engine/common/dense_bone.h"
#include "sim/engine/common/engine_device.h"
#include "sim/engine/dense/cut_voxels.h"
#include "sim/engine/dense/detect_direct.h"
#include "sim/engine/dense/detect_implicit.h"
#include "sim/engine/dense/detect_octree.h"
#include "sim/engine/dense/restore_voxels.h"

namespace reamsim {

namespace {

/// Group sizes where the scenario leaves the choice: detect is one short item per point or voxel; cut strides, and on a
/// CPU wants several groups, because PoCL hands whole groups to threads.
std::size_t group_size(const cl::DeviceInfo& info, int wanted, std::size_t otherwise) {
  return std::min(wanted > 0 ? static_cast<std::size_t>(wanted) : otherwise, info.max_work_group);
}

/// The plan, once it is known to fit.
DensePlan fitting_plan(const cl::DeviceInfo& info, const Scenario& scenario, const BoneView& bone, const Tool& tool) {
  const DensePlan plan =
      plan_dense(engine_of(scenario), bone, tool, scenario.cutting.erosion == ErosionMode::wear);
  require_fit(plan, info, bone.voxmap.grid.voxel_mm);
  return plan;
}

std::unique_ptr<Detection> make_detection(const cl::Device& device, const Scenario& scenario, const DenseState& state,
                                          const DeviceBatch& batch, const BoneView& bone, const Tool& tool) {
  const std::size_t group = group_size(device.info(), scenario.engine.tuning.work_group_size, 256);
  if (engine_of(scenario) == EngineKind::octree) {
    const bool per_point = scenario.cutting.law == CuttingLaw::per_point;
    return std::make_unique<DetectOctree>(device, state, batch, tool.shell, bone.voxmap.grid, per_point, group);
  }
  if (engine_of(scenario) == EngineKind::implicit) {
    return std::make_unique<DetectImplicit>(device, state, batch, tool.profile, bone_extent(bone.voxmap), group);
  }
  return std::make_unique<DetectDirect>(device, state, batch, tool.shell, group);
}

class DenseEngine final : public Engine {
 public:
  DenseEngine(const cl::DeviceInfo& info, const Scenario& scenario, const BoneView& bone, const Tool& tool)
      : device_(info),
        plan_(fitting_plan(info, scenario, bone, tool)),
        state_(make_dense_state(device_, plan_, bone, tool)),
        batch_(device_, plan_.removed_list()),
        detect_(make_detection(device_, scenario, state_, batch_, bone, tool)),
        cut_(device_, plan_.layout, state_, batch_, make_energy_table(scenario.cutting, bone.voxmap.grid.voxel_mm),
             group_size(info, scenario.engine.tuning.work_group_size, info.gpu ? 256 : 16)),
        restorer_(device_) {}

  void enqueue(const SubstepArgs& args) override {
    const int slot = batch_.begin(args);
    detect_->enqueue(slot);
    cut_.enqueue(slot);
  }
  [[nodiscard]] bool full() const override { return batch_.full(); }

  Batch collect() override {
    std::vector<SubstepSums> sums = batch_.collect();
    return {std::move(sums), stage_times(detect_->take_seconds(), cut_.take_seconds())};
  }

  RemovedFrames take_removed() override {
    RemovedFrames removed;
    for (const cl_ulong word : batch_.take_removed()) {
      const auto gone = std::bit_cast<RemovedVoxel>(word);
      removed.emplace_back(gone.voxel, static_cast<std::int32_t>(gone.frame));
    }
    return removed;
  }

  void read_fill(const Voxmap& voxmap, FillBricks& fill) override {
    if (!state_.has_fill) return;
    std::vector<cl_ushort> dense(state_.fill.count());
    state_.fill.read(device_, dense.data(), dense.size());
    copy_fill(dense, voxmap, fill);
  }

  void restore(const BoneView& bone) override { upload_bone(device_, plan_, bone, state_); }
  void restore_voxels(const BoneView& bone, const RemovedFrames& removed) override {
    const auto fill = [&](std::int64_t voxel) -> cl_uint { return bone.fill.get(bone.voxmap.grid.coord(voxel)); };
    const auto grade = [&](std::int64_t voxel) -> cl_uint {
      return fill(voxel) == 0 ? 0 : bone.voxmap.grade.get(bone.voxmap.grid.coord(voxel));
    };
    const auto hu = [&](std::int64_t voxel) {
      return std::bit_cast<cl_uint>(state_.scale.hu(static_cast<std::uint8_t>(grade(voxel))));
    };
    if (plan_.layout == VoxelLayout::flagged_hu) {
      restorer_.put(entries_to_put_back(removed, hu), state_.hu);
    } else {
      restorer_.put(entries_to_put_back(removed, grade), state_.grades);
    }
    if (state_.has_fill) restorer_.put(entries_to_put_back(removed, fill), state_.fill);
  }

  [[nodiscard]] std::string device() const override { return device_.info().name; }
  [[nodiscard]] std::size_t device_bytes() const override { return plan_.bytes(); }
  [[nodiscard]] StructureBytes structure_bytes() const override {
    // A collision flag is part of the published voxel; the claim bits of `direct` are the engine's own.
    const bool flags = plan_.layout == VoxelLayout::flagged_hu;
    return {plan_.bone_bytes() + plan_.fill_bytes() + (flags ? plan_.voxels : 0), plan_.shell_bytes()};
  }

 private:
  cl::Device device_;
  DensePlan plan_;
  DenseState state_;
  DeviceBatch batch_;
  std::unique_ptr<Detection> detect_;
  CutVoxels cut_;
  VoxelRestorer restorer_;
};

}  // namespace

std::unique_ptr<Engine> make_dense_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool) {
  return std::make_unique<DenseEngine>(device_for(scenario.engine), scenario, bone, tool);
}

}  // namespace reamsim
