// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/dense/dense_engine.h"

#include <algorithm>
#include <bit>

#include "sim/engine/common/read_back.h"
#include "sim/engine/dense/dense_kernels.h"
#include "sim/engine/dense/restore_voxels.h"

namespace reamsim {

namespace {

/// The group size of the scenario, or `automatic`. Detect has short work-items, one per point or voxel. Cut strides,
/// and needs several groups on a CPU, because PoCL assigns whole groups to threads.
std::size_t group_size(const cl::DeviceInfo& info, const EngineSettings& engine, std::size_t automatic) {
  const bool given = engine.tuning.work_group_size > 0;
  return std::min(given ? static_cast<std::size_t>(engine.tuning.work_group_size) : automatic, info.max_work_group);
}

DensePlan fitting_plan(const cl::DeviceInfo& info, const Scenario& scenario, const BoneView& bone, const Tool& tool) {
  const DensePlan plan = plan_dense(engine_of(scenario), bone, tool, scenario.cutting.erosion == ErosionMode::wear);
  require_fit(plan, info, bone.voxmap.grid.voxel_mm);
  return plan;
}

class DenseEngine final : public Engine {
 public:
  DenseEngine(const cl::Device& device, const Scenario& scenario, const BoneView& bone, const Tool& tool)
      : device_(device),
        plan_(fitting_plan(device.info(), scenario, bone, tool)),
        state_(make_dense_state(device_, plan_, bone, tool,
                                make_energy_table(scenario.cutting, bone.voxmap.grid.voxel_mm))),
        batch_(device_, plan_.removed_list()),
        detect_(make_detect_kernel(device_, scenario, state_, batch_, bone, tool,
                                   group_size(device.info(), scenario.engine, 256))),
        cut_(make_cut_kernel(device_, plan_, state_, batch_,
                             group_size(device.info(), scenario.engine, device.info().gpu ? 256 : 16))),
        restorer_(device_) {}

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> /*window*/) override {
    const int slot = batch_.begin(args);
    detect_.enqueue(slot, args);
    cut_.enqueue(slot, args);
  }
  [[nodiscard]] bool full() const override { return batch_.full(); }

  Batch collect() override {
    std::vector<SubstepSums> sums = batch_.collect();
    return {.sums = std::move(sums), .times = stage_times(detect_.kernel.take_seconds(), cut_.kernel.take_seconds())};
  }

  RemovedFrames take_removed() override {
    RemovedFrames removed;
    for (const cl_ulong word : batch_.take_removed()) {
      const auto [voxel, frame] = std::bit_cast<RemovedVoxel>(word);
      removed.emplace_back(voxel, static_cast<std::int32_t>(frame));
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
      restorer_.write(entries_to_restore(removed, hu), state_.hu);
    } else {
      restorer_.write(entries_to_restore(removed, grade), state_.grades);
    }
    if (state_.has_fill) restorer_.write(entries_to_restore(removed, fill), state_.fill);
  }

  [[nodiscard]] std::string device() const override { return device_.info().name; }
  [[nodiscard]] std::size_t device_bytes() const override { return plan_.bytes(); }
  [[nodiscard]] StructureBytes structure_bytes() const override {
    // A collision flag is part of the published voxel; the claim bits of `direct` are not published.
    const bool flags = plan_.layout == VoxelLayout::flagged_hu;
    return {plan_.bone_bytes() + plan_.fill_bytes() + (flags ? plan_.voxels : 0), plan_.shell_bytes()};
  }

 private:
  cl::Device device_;
  DensePlan plan_;
  DenseState state_;
  DeviceBatch batch_;
  DenseStage detect_;
  DenseStage cut_;
  VoxelRestorer restorer_;
};

}  // namespace

std::unique_ptr<Engine> make_dense_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                          const Tool& tool) {
  return std::make_unique<DenseEngine>(device, scenario, bone, tool);
}

}  // namespace reamsim
