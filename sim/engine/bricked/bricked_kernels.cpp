// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/bricked/bricked_kernels.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_detect_bricked;
extern const char* const kernel_cut_bricked;
}  // namespace embedded

BrickedStage make_detect_bricked(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch,
                                 const KernelOptions& options) {
  const std::string defines = kernel_defines(state.bone.layout, options.shape);
  BrickedStage out{{device, device.build("detect_bricked.cl", embedded::kernel_detect_bricked, defines),
                    "detect_bricked", options.work_group},
                   options.shape == KernelShape::cpu ? state.runs.count() : state.cells.count() * options.work_group};
  out.kernel.set_from(cl::SlotKernel::kAfterSlot, batch.args(), state.cells, static_cast<cl_uint>(state.cells.count()),
                      state.runs, cl_uint{kRunCells}, state.offsets, state.bone.slot_of_brick, state.bone.occupancy,
                      state.listed, state.touched_list, batch.contact_count(), batch.sums(), state.bone.dims,
                      cl_int{options.culling ? 1 : 0}, batch.removed_room(), batch.removed_count(),
                      batch.removed_before(), state.outline.arguments(), state.bone.pool_arguments());
  return out;
}

BrickedStage make_cut_bricked(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch,
                              const KernelOptions& options) {
  const std::string defines = cut_defines(state.bone.layout, options.shape);
  BrickedStage out{{device, device.build("cut_bricked.cl", embedded::kernel_cut_bricked, defines), "cut_bricked",
                    options.work_group},
                   cut_items(device.info(), options)};
  out.kernel.set_from(cl::SlotKernel::kAfterSlot, batch.args(), state.bone.lattice_of_slot, state.listed,
                      state.bone.occupancy, state.touched_list, batch.contact_count(), batch.sums(), batch.removed(),
                      batch.removed_count(), batch.removed_room(), batch.removed_before(), state.energy_of_grade,
                      state.units_of_grade, state.density_of_grade, state.bits_of_byte, state.bone.dims,
                      state.outline.arguments(), state.bone.pool_arguments());
  return out;
}

}  // namespace reamsim
