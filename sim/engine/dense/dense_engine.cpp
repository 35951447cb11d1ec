// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/engine.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "sim/device/opencl.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/substep.h"
#include "sim/engine/dense/dense_state.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_dense;
}

namespace {

/// Writes value(voxel index) of the removed voxels into an array of 8, 16 or 32 bits per voxel.
template <class T, class Value>
void restore_removed(const cl::Device& device, const RemovedFrames& removed, const Value& value,
                     const cl::Buffer<T>& array) {
  constexpr const char* kName = sizeof(T) == 1 ? "restore_bytes" : sizeof(T) == 2 ? "restore_halves" : "restore_words";
  constexpr std::size_t kGroup = 64;
  if (removed.empty()) return;
  std::vector<cl_uint2> values;
  for (const auto& [voxel, frame] : removed) values.push_back({{static_cast<cl_uint>(voxel), value(voxel)}});
  const auto list = cl::upload(device, values, "the voxels to restore");
  cl::Kernel kernel(device.build("dense.cl", embedded::kernel_dense), kName);
  kernel.set_from(0, list, static_cast<cl_uint>(values.size()), array);
  const cl::Event done = kernel.launch(device, values.size(), kGroup);
  device.finish();
}

/// The narrow phase: writes the voxels that the tool touches in a substep to the contact list, each once, and changes
/// nothing that the cut writes. Results do not depend on the size of a group.
/// `direct` is the paper's (§3.5): one work-item per shell point, a Morton code. `octree` is that of Zheng et al. as
/// Faieghi et al. (2020, §4.3.1) rebuilt it: one work-item per shell point, three floats, that descends the grid
/// through look-up tables. `implicit` is that of Yau et al., rebuilt likewise (§4.3.2): one work-item per voxel of the
/// VOI, which set_voi() sets, against the tool's solid of revolution.
cl::SlotKernel make_detect_kernel(const cl::Device& device, const DensePlan& plan, const DenseState& state,
                                  const DeviceBatch& batch, bool per_point, std::size_t work_group) {
  if (plan.layout == VoxelLayout::bare_grade) {
    constexpr cl_uint kAfterVoi = 3;
    cl::SlotKernel out(device, device.build("dense.cl", embedded::kernel_dense), "detect_implicit", work_group);
    out.set_from(kAfterVoi, batch.args(), state.grades, state.contacts, batch.contact_count(), state.outline);
    return out;
  }
  if (plan.has_hu()) {
    constexpr std::size_t kMaxPerGroup = 256;  // the reduction takes 48 bytes of local memory per work-item
    const std::size_t group = std::min(work_group, kMaxPerGroup);
    const std::string defines = per_point ? "-DREAMSIM_GROUP_SIZE=" + std::to_string(group) : "";
    cl::SlotKernel out(device, device.build("dense.cl", embedded::kernel_dense, defines), "detect_octree", group,
                       state.point_count);
    out.set_from(cl::SlotKernel::kAfterSlot, batch.args(), state.points, state.point_count, state.hu,
                 state.scale.of_air, state.claims, state.contacts, batch.contact_count(), batch.sums(), state.outline,
                 state.children, state.levels);
    return out;
  }
  const char* defines = plan.wide_codes ? "-DRS_WIDE_CODES" : "";
  cl::SlotKernel out(device, device.build("dense.cl", embedded::kernel_dense, defines), "detect_direct", work_group,
                     state.point_count);
  out.set_from(cl::SlotKernel::kAfterSlot, batch.args(), state.codes, state.point_count, state.grades, state.claims,
               state.contacts, batch.contact_count(), batch.sums(), state.outline);
  return out;
}

/// Sets the VOI of detect_implicit, and returns the number of its voxels.
std::size_t set_voi(const VoxelBox& voi, cl::SlotKernel& kernel) {
  const Vec3i size = voi.size();
  const auto n = [&](int axis) { return static_cast<cl_uint>(size[axis]); };
  kernel.set_from(cl::SlotKernel::kAfterSlot, cl_int4{{voi.first.x(), voi.first.y(), voi.first.z(), 0}},
                  cl_uint4{{n(0), n(1), n(2), 0}});
  return static_cast<std::size_t>(size.cast<std::int64_t>().prod());
}

/// The cut for `remove` and `wear`: work-items stride over the contact list.
cl::SlotKernel make_cut_kernel(const cl::Device& device, const DensePlan& plan, const DenseState& state,
                               const DeviceBatch& batch, std::size_t work_group) {
  const bool hu = plan.has_hu();
  const char* defines = hu ? "-DREAMSIM_FLAGGED_HU" : "";
  if (plan.layout == VoxelLayout::bare_grade) defines = "-DREAMSIM_BARE_GRADE";
  // Enough work-items to fill the device: few long ones on a CPU, many on a GPU.
  const std::size_t items = std::size_t{device.info().compute_units} * (device.info().gpu ? 1024 : 64);
  cl::SlotKernel out(device, device.build("dense.cl", embedded::kernel_dense, defines), "cut_voxels", work_group,
                     items);
  out.set_from(cl::SlotKernel::kAfterSlot, batch.args(), hu ? state.hu.get() : state.grades.get(), state.fill,
               cl_int{state.has_fill ? 1 : 0}, state.claims, state.contacts, batch.contact_count(), batch.sums(),
               batch.removed(), batch.removed_count(), state.units_of_grade, state.density_of_grade, state.outline,
               state.scale.of_air, state.scale.per_grade);
  return out;
}

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
        tool_box_(tool.profile.bounds()),
        extent_(bone_extent(bone.voxmap)),
        detect_(make_detect_kernel(device_, plan_, state_, batch_, scenario.cutting.law == CuttingLaw::per_point,
                                   group_size(device.info(), scenario.engine, 256))),
        cut_(make_cut_kernel(device_, plan_, state_, batch_,
                             group_size(device.info(), scenario.engine, device.info().gpu ? 256 : 16))) {}

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> /*window*/) override {
    const int slot = batch_.begin(args);
    if (plan_.layout == VoxelLayout::bare_grade) {
      detect_.run(slot, set_voi(voxel_voi(args, tool_box_, extent_), detect_));
    } else {
      detect_.run(slot);
    }
    cut_.run(slot);
  }
  [[nodiscard]] bool full() const override { return batch_.full(); }

  Batch collect() override { return {.sums = batch_.collect(), .times = stage_times(detect_, cut_)}; }

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
    if (plan_.has_hu()) {
      restore_removed(device_, removed, hu, state_.hu);
    } else {
      restore_removed(device_, removed, grade, state_.grades);
    }
    if (state_.has_fill) restore_removed(device_, removed, fill, state_.fill);
  }

  [[nodiscard]] std::string device() const override { return device_.info().name; }
  [[nodiscard]] std::size_t device_bytes() const override { return plan_.bytes(); }
  [[nodiscard]] StructureBytes structure_bytes() const override {
    // A collision flag is part of the published voxel; the claim bits of `direct` are not published.
    const bool flags = plan_.has_hu();
    return {plan_.bone_bytes() + plan_.fill_bytes() + (flags ? plan_.voxels : 0), plan_.shell_bytes()};
  }

 private:
  cl::Device device_;
  DensePlan plan_;
  DenseState state_;
  DeviceBatch batch_;
  Aabb tool_box_;    ///< T, mm
  VoxelBox extent_;  ///< of the bone
  cl::SlotKernel detect_, cut_;
};

}  // namespace

std::unique_ptr<Engine> make_dense_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                          const Tool& tool) {
  return std::make_unique<DenseEngine>(device, scenario, bone, tool);
}

}  // namespace reamsim
