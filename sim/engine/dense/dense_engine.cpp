// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/engines.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <vector>

#include "sim/device/opencl.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/substep.h"
#include "sim/engine/dense/dense_state.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_restore_voxels;
extern const char* const kernel_cut_voxels;
extern const char* const kernel_detect_direct;
extern const char* const kernel_detect_implicit;
extern const char* const kernel_detect_octree;
}  // namespace embedded

namespace {

/// Restores single voxels of dense arrays, so that a benchmark need not upload the whole bone before each repetition.
class VoxelRestorer {
 public:
  /// A voxel's index and its value, the bits of a float.
  struct Entry {
    cl_uint voxel;
    cl_uint value;
  };

  explicit VoxelRestorer(const cl::Device& device);
  /// Writes the entries into an array of 8, 16 or 32 bits per voxel, and waits for the device.
  template <class T>
  void write(const std::vector<Entry>& entries, const cl::Buffer<T>& values) {
    static_assert(sizeof(T) == 1 || sizeof(T) == 2 || sizeof(T) == 4);
    write(entries, values.get(), sizeof(T) == 1 ? bytes_ : sizeof(T) == 2 ? halves_ : words_);
  }

 private:
  void write(const std::vector<Entry>& entries, cl_mem values, cl::Kernel& kernel);

  const cl::Device& device_;
  cl::Program program_;
  cl::Kernel bytes_, halves_, words_;
};

/// The voxels of `removed` with value(voxel index).
template <class Value>
std::vector<VoxelRestorer::Entry> entries_to_restore(const RemovedFrames& removed, Value value) {
  std::vector<VoxelRestorer::Entry> entries;
  entries.reserve(removed.size());
  for (const auto& [voxel, frame] : removed) entries.push_back({static_cast<cl_uint>(voxel), value(voxel)});
  return entries;
}

VoxelRestorer::VoxelRestorer(const cl::Device& device)
    : device_(device),
      program_(device.build("restore_voxels.cl", embedded::kernel_restore_voxels)),
      bytes_(program_, "restore_bytes"),
      halves_(program_, "restore_halves"),
      words_(program_, "restore_words") {}

void VoxelRestorer::write(const std::vector<Entry>& entries, cl_mem values, cl::Kernel& kernel) {
  constexpr std::size_t kGroup = 64;
  if (entries.empty()) return;
  const auto list = cl::upload(device_, entries, "the voxels to restore");
  kernel.set_from(0, list, static_cast<cl_uint>(entries.size()), values);
  const cl::Event done = kernel.launch(device_, entries.size(), kGroup);
  device_.finish();
}

/// A stage over a dense voxmap with its arguments.
struct DenseStage {
  cl::SlotKernel kernel;
  /// Sets the arguments that a substep changes, beside its slot, and returns the number of work-items.
  std::function<std::size_t(const SubstepArgs&, cl::SlotKernel&)> prepare;

  void enqueue(int slot, const SubstepArgs& args) { kernel.run(slot, prepare(args, kernel)); }
};

auto always(std::size_t items) {
  return [items](const SubstepArgs&, cl::SlotKernel&) { return items; };
}

DenseStage make_detect_direct(const cl::Device& device, const DenseState& state, const DeviceBatch& batch,
                              bool wide_codes, std::size_t work_group) {
  const cl::Program program =
      device.build("detect_direct.cl", embedded::kernel_detect_direct, wide_codes ? "-DRS_WIDE_CODES" : "");
  DenseStage out{{device, program, "detect_direct", work_group}, always(state.point_count)};
  out.kernel.set_from(cl::SlotKernel::kAfterSlot, batch.args(), state.codes, state.point_count, state.grades,
                      state.claims, state.contacts, batch.contact_count(), batch.sums(), state.outline.arguments());
  return out;
}

DenseStage make_detect_octree(const cl::Device& device, const DenseState& state, const DeviceBatch& batch,
                              bool per_point, std::size_t work_group) {
  constexpr std::size_t kMaxPerGroup = 256;  // the reduction takes 48 bytes of local memory per work-item
  const std::size_t group = std::min(work_group, kMaxPerGroup);
  const std::string defines = per_point ? "-DREAMSIM_GROUP_SIZE=" + std::to_string(group) : "";
  DenseStage out{
      {device, device.build("detect_octree.cl", embedded::kernel_detect_octree, defines), "detect_octree", group},
      always(state.point_count)};
  out.kernel.set_from(cl::SlotKernel::kAfterSlot, batch.args(), state.points, state.point_count, state.hu,
                      static_cast<cl_float>(state.scale.of_air), state.claims, state.contacts, batch.contact_count(),
                      batch.sums(), state.outline.arguments(), state.children, state.levels);
  return out;
}

DenseStage make_detect_implicit(const cl::Device& device, const DenseState& state, const DeviceBatch& batch,
                                const Aabb& tool_box, const VoxelBox& bone, std::size_t work_group) {
  const auto prepare = [tool_box, bone](const SubstepArgs& args, cl::SlotKernel& kernel) {
    const VoxelBox voi = voxel_voi(args, tool_box, bone);
    const Vec3i size = voi.size();
    const auto n = [&](int axis) { return static_cast<cl_uint>(size[axis]); };
    kernel.set_from(cl::SlotKernel::kAfterSlot, cl_int4{{voi.first.x(), voi.first.y(), voi.first.z(), 0}},
                    cl_uint4{{n(0), n(1), n(2), 0}});
    return static_cast<std::size_t>(size.cast<std::int64_t>().prod());
  };
  DenseStage out{
      {device, device.build("detect_implicit.cl", embedded::kernel_detect_implicit), "detect_implicit", work_group},
      prepare};
  constexpr cl_uint kAfterVoi = 3;
  out.kernel.set_from(kAfterVoi, batch.args(), state.grades, state.contacts, batch.contact_count(),
                      state.outline.arguments());
  return out;
}

/// The narrow phase: writes the voxels that the tool touches in a substep to the contact list, each once, and changes
/// nothing that the cut writes. `work_group` is the size of a group; results do not depend on it.
///
/// `direct` is the paper's (§3.5): one work-item per shell point, a Morton code. `octree` is that of Zheng et al. as
/// Faieghi et al. (2020, §4.3.1) rebuilt it: one work-item per shell point, three floats, that descends the grid
/// through look-up tables. `implicit` is that of Yau et al., rebuilt likewise (§4.3.2): one work-item per voxel of the
/// VOI against the tool's solid of revolution.
DenseStage make_detect_kernel(const cl::Device& device, const Scenario& scenario, const DenseState& state,
                              const DeviceBatch& batch, const BoneView& bone, const Tool& tool,
                              std::size_t work_group) {
  if (engine_of(scenario) == EngineKind::octree) {
    return make_detect_octree(device, state, batch, scenario.cutting.law == CuttingLaw::per_point, work_group);
  }
  if (engine_of(scenario) == EngineKind::implicit) {
    return make_detect_implicit(device, state, batch, tool.profile.bounds(), bone_extent(bone.voxmap), work_group);
  }
  return make_detect_direct(device, state, batch, has_wide_codes(tool.shell), work_group);
}

/// The cut for `remove` and `wear`: work-items stride over the contact list.
DenseStage make_cut_kernel(const cl::Device& device, const DensePlan& plan, const DenseState& state,
                           const DeviceBatch& batch, std::size_t work_group) {
  const bool hu = plan.layout == VoxelLayout::flagged_hu;
  const char* defines = hu ? "-DREAMSIM_FLAGGED_HU" : "";
  if (plan.layout == VoxelLayout::bare_grade) defines = "-DREAMSIM_BARE_GRADE";
  // Enough work-items to fill the device: few long ones on a CPU, many on a GPU.
  const std::size_t items = std::size_t{device.info().compute_units} * (device.info().gpu ? 1024 : 64);
  DenseStage out{
      {device, device.build("cut_voxels.cl", embedded::kernel_cut_voxels, defines), "cut_voxels", work_group},
      always(items)};
  out.kernel.set_from(cl::SlotKernel::kAfterSlot, batch.args(), hu ? state.hu.get() : state.grades.get(), state.fill,
                      cl_int{state.has_fill ? 1 : 0}, state.claims, state.contacts, batch.contact_count(), batch.sums(),
                      batch.removed(), batch.removed_count(), state.energy_of_grade, state.density_of_grade,
                      state.outline.arguments(), state.scale.of_air, state.scale.per_grade);
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
