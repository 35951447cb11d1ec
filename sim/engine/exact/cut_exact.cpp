// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/exact/cut_exact.h"

#include <algorithm>

namespace reamsim {

namespace embedded {
extern const char* const kernel_cut_exact;
}

namespace {

/// Number of the first argument that all visits share; those before it are set by enqueue().
constexpr cl_uint kAfterPlan = 6;

/// On a CPU the items of a group run one after another, each with some 60 KB on the stack.
constexpr std::size_t kMostItemsOnStack = 16;

std::size_t group_size(const KernelOptions& options) {
  return options.shape == KernelShape::cpu ? std::min(options.work_group, kMostItemsOnStack) : options.work_group;
}

}  // namespace

CutExact::CutExact(const cl::Device& device, const DeviceBricks& bone, const DeviceBatch& batch, const ListBricks& list,
                   const OutlineTable& outline, const EnergyTable& table, const KernelOptions& options,
                   const DeviceTeeth* teeth)
    : device_(device),
      // On a CPU a work-item takes bricks until none is left.
      items_(options.shape == KernelShape::cpu ? device.info().compute_units * group_size(options)
                                               : cut_items(device.info(), options)),
      energy_(
          cl::upload(device, std::vector<float>(table.energy_mj.begin(), table.energy_mj.end()), "the energy table")),
      windows_(device, RS_VISIT_SUBSTEPS, "the windows of a visit"),
      motions_(device, RS_VISIT_SUBSTEPS, "the windows of a visit"),
      outline_(device, outline),
      kernel_(device,
              device.build("cut_exact.cl", embedded::kernel_cut_exact,
                           cut_defines(bone.layout, options.shape) + (teeth != nullptr ? " -DRS_DISTANCE_GRID" : "")),
              "cut_exact", group_size(options)) {
  const std::vector<cl_mem> pools = bone.pool_arguments();
  const auto set_constant = [&](const auto&... teeth_arguments) {
    kernel_.set_from(kAfterPlan, batch.args(), windows_, motions_, list.listed(), list.counts(), bone.lattice_of_slot,
                     bone.occupancy, bone.dims, batch.sums(), energy_, outline_.arguments(), pools, teeth_arguments...);
  };
  teeth != nullptr ? set_constant(teeth->arguments()) : set_constant();
}

std::size_t CutExact::max_records(std::size_t listed, int substeps) {
  // The 64 voxels of a block can be removed in as many substeps.
  return listed * 8 * static_cast<std::size_t>(std::min(substeps, 64));
}

void CutExact::enqueue(const BrickBatchPlan& plan, const FillPages& fill, const cl::Buffer<RemovedBlock>& removed) {
  windows_.write(device_, plan.windows.data(), plan.windows.size(), 0, false);
  if (!plan.motions.empty()) motions_.write(device_, plan.motions.data(), plan.motions.size(), 0, false);
  kernel_.set_from(cl::SlotKernel::kAfterSlot, static_cast<cl_uint>(plan.windows.size()), fill.page_of_slot,
                   fill.slot_of_page, fill.fills, removed);
  kernel_.run(plan.first, items_);
}

}  // namespace reamsim
