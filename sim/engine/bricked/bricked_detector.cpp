#include "sim/engine/bricked/bricked_detector.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_detect_bricked;
}

BrickedDetector::BrickedDetector(const cl::Device& device, BrickedState& state, const DeviceBatch& batch,
                                 const BrickedOptions& options)
    : items_(options.shape == KernelShape::cpu ? state.runs.count() : state.cells.count() * options.work_group),
      kernel_(device,
              device.build("detect_bricked.cl", embedded::kernel_detect_bricked, state.layout.defines(options.shape)),
              "detect_bricked", 1, options.work_group) {
  kernel_.set(0, batch.args());
  kernel_.set(2, state.cells);
  kernel_.set(3, static_cast<cl_uint>(state.cells.count()));
  kernel_.set(4, state.runs);
  kernel_.set(5, static_cast<cl_uint>(kRunCells));
  kernel_.set(6, state.offsets);
  kernel_.set(7, state.slot_of_brick);
  kernel_.set(8, state.occupancy);
  kernel_.set(9, state.listed);
  kernel_.set(10, state.touched_list);
  kernel_.set(11, batch.contact_count());
  kernel_.set(12, batch.sums());
  kernel_.set(13, state.bricks);
  kernel_.set(14, static_cast<cl_int>(options.culling ? 1 : 0));
  kernel_.set(15, batch.removed_room());
  kernel_.set(16, batch.removed_count());
  kernel_.set(17, batch.removed_before());
  state.profile.set(kernel_, 18);
  state.set_pools(kernel_, 22);
}

void BrickedDetector::detect(int slot) {
  kernel_.run(slot, items_);
}

}  // namespace reamsim
