// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/dense/dense_kernels.h"

#include <algorithm>

#include "sim/engine/common/broad_phase.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_cut_voxels;
extern const char* const kernel_detect_direct;
extern const char* const kernel_detect_implicit;
extern const char* const kernel_detect_octree;
}  // namespace embedded

namespace {

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

}  // namespace

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

}  // namespace reamsim
