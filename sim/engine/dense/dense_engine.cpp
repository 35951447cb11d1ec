#include "sim/engine/dense/dense_engine.h"

#include <algorithm>
#include <bit>

#include "sim/engine/common/dense_bone.h"
#include "sim/engine/common/engine_device.h"
#include "sim/engine/dense/device_erosion.h"
#include "sim/engine/dense/direct_detector.h"
#include "sim/engine/dense/implicit_detector.h"
#include "sim/engine/dense/octree_detector.h"
#include "sim/engine/dense/voxel_restorer.h"

namespace reamsim {

namespace {

/// Group sizes where the scenario leaves the choice: detect is one short item per point or voxel; cut strides, and on a
/// CPU wants several groups, because PoCL hands whole groups to threads.
std::size_t group_size(const cl::DeviceInfo& info, int wanted, std::size_t otherwise) {
  return std::min(wanted > 0 ? static_cast<std::size_t>(wanted) : otherwise, info.max_work_group);
}

/// The plan, once it is known to fit.
DensePlan fitting_plan(const cl::DeviceInfo& info, const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  const DensePlan plan =
      plan_dense(scenario.engine.detector, voxmap, tool, scenario.cutting.erosion == ErosionMode::wear);
  require_fit(plan, info, voxmap.grid.voxel_mm);
  return plan;
}

std::unique_ptr<Detector> make_detector(const cl::Device& device, const Scenario& scenario, const DenseState& state,
                                        const DeviceBatch& batch, const Voxmap& voxmap, const Tool& tool) {
  const std::size_t group = group_size(device.info(), scenario.engine.work_group_size, 256);
  if (scenario.engine.detector == EngineKind::octree) {
    const bool per_point = scenario.cutting.law == CuttingLaw::per_point;
    return std::make_unique<OctreeDetector>(device, state, batch, tool.shell, voxmap.grid, per_point, group);
  }
  if (scenario.engine.detector == EngineKind::implicit) {
    return std::make_unique<ImplicitDetector>(device, state, batch, tool.profile, bone_extent(voxmap), group);
  }
  return std::make_unique<DirectDetector>(device, state, batch, tool.shell, group);
}

class DenseEngine final : public Engine {
 public:
  DenseEngine(const cl::DeviceInfo& info, const Scenario& scenario, const Voxmap& voxmap, const Tool& tool)
      : device_(info),
        plan_(fitting_plan(info, scenario, voxmap, tool)),
        state_(make_dense_state(device_, plan_, voxmap, tool)),
        batch_(device_, plan_.removed_list()),
        detector_(make_detector(device_, scenario, state_, batch_, voxmap, tool)),
        erosion_(device_, plan_.layout, state_, batch_, make_energy_table(scenario.cutting, voxmap.grid.voxel_mm),
                 group_size(info, scenario.engine.work_group_size, info.gpu ? 256 : 16)),
        restorer_(device_) {}

  int begin(const SubstepArgs& args) override { return batch_.begin(args); }
  Detector& detector() override { return *detector_; }
  Erosion& erosion() override { return erosion_; }
  [[nodiscard]] bool full() const override { return batch_.full(); }

  Batch collect() override { return {batch_.collect(), detector_->take_seconds(), erosion_.take_seconds()}; }

  RemovedFrames take_removed() override {
    RemovedFrames removed;
    for (const cl_ulong word : batch_.take_removed()) {
      const auto gone = std::bit_cast<RemovedVoxel>(word);
      removed.emplace_back(gone.voxel, static_cast<std::int32_t>(gone.frame));
    }
    return removed;
  }

  void read_fill(Voxmap& voxmap) override {
    if (!state_.has_fill) return;
    std::vector<cl_ushort> fill(state_.fill.count());
    state_.fill.read(device_, fill.data(), fill.size());
    copy_fill(fill, voxmap);
  }

  void restore(const Voxmap& voxmap) override { upload_bone(device_, plan_, voxmap, state_); }
  void restore_voxels(const Voxmap& voxmap, const RemovedFrames& gone) override {
    const auto fill = [&](std::int64_t voxel) -> cl_uint { return voxmap.fill.get(voxmap.grid.coord(voxel)); };
    const auto grade = [&](std::int64_t voxel) -> cl_uint {
      return fill(voxel) == 0 ? 0 : voxmap.grade.get(voxmap.grid.coord(voxel));
    };
    const auto hu = [&](std::int64_t voxel) {
      return std::bit_cast<cl_uint>(state_.scale.hu(static_cast<std::uint8_t>(grade(voxel))));
    };
    if (plan_.layout == VoxelLayout::flagged_hu) {
      restorer_.put(entries_to_put_back(gone, hu), state_.hu);
    } else {
      restorer_.put(entries_to_put_back(gone, grade), state_.grades);
    }
    if (state_.has_fill) restorer_.put(entries_to_put_back(gone, fill), state_.fill);
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
  std::unique_ptr<Detector> detector_;
  DeviceErosion erosion_;
  VoxelRestorer restorer_;
};

}  // namespace

std::unique_ptr<Engine> make_dense_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool) {
  return std::make_unique<DenseEngine>(device_for(scenario.engine), scenario, voxmap, tool);
}

}  // namespace reamsim
