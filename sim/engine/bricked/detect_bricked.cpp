#include "sim/engine/bricked/detect_bricked.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_detect_bricked;
}

DetectBricked::DetectBricked(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch,
                             const KernelOptions& options)
    : items_(options.shape == KernelShape::cpu ? state.runs.count() : state.cells.count() * options.work_group),
      kernel_(device,
              device.build("detect_bricked.cl", embedded::kernel_detect_bricked,
                           kernel_defines(state.bone.layout, options.shape)),
              "detect_bricked", Argument::substep, options.work_group) {
  kernel_.set(Argument::args, batch.args());
  kernel_.set(Argument::cells, state.cells);
  kernel_.set(Argument::cell_count, static_cast<cl_uint>(state.cells.count()));
  kernel_.set(Argument::runs, state.runs);
  kernel_.set(Argument::run_cells, static_cast<cl_uint>(kRunCells));
  kernel_.set(Argument::offsets, state.offsets);
  kernel_.set(Argument::slot_of_brick, state.bone.slot_of_brick);
  kernel_.set(Argument::occupancy, state.bone.occupancy);
  kernel_.set(Argument::listed, state.listed);
  kernel_.set(Argument::touched_list, state.touched_list);
  kernel_.set(Argument::touched_count, batch.contact_count());
  kernel_.set(Argument::sums, batch.sums());
  kernel_.set(Argument::bricks, state.bone.dims);
  kernel_.set(Argument::culling, static_cast<cl_int>(options.culling ? 1 : 0));
  kernel_.set(Argument::room, batch.removed_room());
  kernel_.set(Argument::removed_count, batch.removed_count());
  kernel_.set(Argument::removed_before, batch.removed_before());
  state.profile.set(kernel_, Argument::edges);
  state.bone.set_pools(kernel_, Argument::pool_0);
}

void DetectBricked::enqueue(int slot) {
  kernel_.run(slot, items_);
}

}  // namespace reamsim
