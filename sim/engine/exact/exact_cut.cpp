#include "sim/engine/exact/exact_cut.h"

#include <algorithm>
#include <numeric>

namespace reamsim {

namespace embedded {
extern const char* const kernel_cut_exact;
}

namespace {

/// Sums of a substep in kernels/cut_exact.cl, in the lanes of a vector.
constexpr std::size_t kLanesOfSubstep = 10 * 16;

/// Every work-item that a launch starts keeps sums for a visit's substeps: groups are whole.
std::size_t lane_count(std::size_t items, const BrickedOptions& options) {
  if (options.shape != KernelShape::cpu) return 1;
  const std::size_t groups = (items + options.work_group - 1) / options.work_group;
  return groups * options.work_group * RS_VISIT_SUBSTEPS * kLanesOfSubstep;
}

}  // namespace

ExactCut::ExactCut(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch,
                   const ExactReach& reach, const OutlineTable& outline, const EnergyTable& table,
                   const BrickedOptions& options, const DeviceTeeth* teeth)
    : device_(device),
      items_(cut_items(device.info(), options)),
      work_group_(options.work_group),
      energy_(device, table.energy_mj.size(), "the energy table"),
      windows_(device, RS_VISIT_SUBSTEPS, "the windows of a visit"),
      lanes_(device, lane_count(items_, options), "the sums of a visit"),
      outline_(device, outline),
      kernel_(device.build("cut_exact.cl", embedded::kernel_cut_exact,
                           cut_defines(state.layout, options.shape) + (teeth != nullptr ? " -DRS_DISTANCE_GRID" : "")),
              "cut_exact") {
  std::vector<float> energy(table.energy_mj.size());
  std::transform(table.energy_mj.begin(), table.energy_mj.end(), energy.begin(),
                 [](double mj) { return static_cast<float>(mj); });
  energy_.write(device, energy.data(), energy.size());
  kernel_.set(0, batch.args());
  kernel_.set(1, windows_);
  kernel_.set(3, reach.listed());
  kernel_.set(4, reach.counts());
  kernel_.set(5, state.lattice_of_slot);
  kernel_.set(6, state.occupancy);
  kernel_.set(7, state.bricks);
  kernel_.set(11, batch.sums());
  kernel_.set(13, energy_);
  outline_.set(kernel_, 14);
  kernel_.set(18, lanes_);
  state.set_pools(kernel_, 19);
  if (teeth != nullptr) teeth->set(kernel_, 19 + static_cast<cl_uint>(state.layout.pools));
}

std::size_t ExactCut::most_records(std::size_t listed, int substeps) {
  // A block of 64 voxels can lose its last ones in as many substeps.
  return listed * 8 * static_cast<std::size_t>(std::min(substeps, 64));
}

void ExactCut::visit(const VisitPlan& plan, const FillPages& fill, const cl::Buffer<RemovedBlock>& removed) {
  windows_.write(device_, plan.windows.data(), plan.windows.size());
  kernel_.set(2, static_cast<cl_uint>(plan.windows.size()));
  kernel_.set(8, fill.page_of_slot);
  kernel_.set(9, fill.slot_of_page);
  kernel_.set(10, fill.fills);
  kernel_.set(12, removed);
  events_.push_back(kernel_.launch(device_, items_, work_group_));
}

double ExactCut::take_seconds() {
  const std::vector<double> seconds = cl::take_seconds(events_);
  return std::accumulate(seconds.begin(), seconds.end(), 0.0);
}

}  // namespace reamsim
