#include "sim/engine/exact/cut_exact.h"

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
std::size_t lane_count(std::size_t items, const KernelOptions& options) {
  if (options.shape != KernelShape::cpu) return 1;
  const std::size_t groups = (items + options.work_group - 1) / options.work_group;
  return groups * options.work_group * RS_VISIT_SUBSTEPS * kLanesOfSubstep;
}

}  // namespace

CutExact::CutExact(const cl::Device& device, const DeviceBricks& bone, const DeviceBatch& batch, const ListBricks& list,
                   const OutlineTable& outline, const EnergyTable& table, const KernelOptions& options,
                   const DeviceTeeth* teeth)
    : device_(device),
      items_(cut_items(device.info(), options)),
      work_group_(options.work_group),
      energy_(device, table.energy_mj.size(), "the energy table"),
      windows_(device, RS_VISIT_SUBSTEPS, "the windows of a visit"),
      lanes_(device, lane_count(items_, options), "the sums of a visit"),
      outline_(device, outline),
      kernel_(device.build("cut_exact.cl", embedded::kernel_cut_exact,
                           cut_defines(bone.layout, options.shape) + (teeth != nullptr ? " -DRS_DISTANCE_GRID" : "")),
              "cut_exact") {
  std::vector<float> energy(table.energy_mj.size());
  std::transform(table.energy_mj.begin(), table.energy_mj.end(), energy.begin(),
                 [](double mj) { return static_cast<float>(mj); });
  energy_.write(device, energy.data(), energy.size());
  kernel_.set(Argument::args, batch.args());
  kernel_.set(Argument::windows, windows_);
  kernel_.set(Argument::listed, list.listed());
  kernel_.set(Argument::counts, list.counts());
  kernel_.set(Argument::lattice_of_slot, bone.lattice_of_slot);
  kernel_.set(Argument::occupancy, bone.occupancy);
  kernel_.set(Argument::bricks, bone.dims);
  kernel_.set(Argument::sums, batch.sums());
  kernel_.set(Argument::energy_of_grade, energy_);
  outline_.set(kernel_, Argument::pieces);
  kernel_.set(Argument::lanes_of_item, lanes_);
  bone.set_pools(kernel_, Argument::pool_0);
  if (teeth != nullptr)
    teeth->set(kernel_, static_cast<cl_uint>(Argument::pool_0) + static_cast<cl_uint>(bone.layout.pools));
}

std::size_t CutExact::most_records(std::size_t listed, int substeps) {
  // A block of 64 voxels can lose its last ones in as many substeps.
  return listed * 8 * static_cast<std::size_t>(std::min(substeps, 64));
}

void CutExact::enqueue(const VisitPlan& plan, const FillPages& fill, const cl::Buffer<RemovedBlock>& removed) {
  windows_.write(device_, plan.windows.data(), plan.windows.size());
  kernel_.set(Argument::window_count, static_cast<cl_uint>(plan.windows.size()));
  kernel_.set(Argument::page_of_slot, fill.page_of_slot);
  kernel_.set(Argument::slot_of_page, fill.slot_of_page);
  kernel_.set(Argument::pages, fill.fills);
  kernel_.set(Argument::removed, removed);
  events_.push_back(kernel_.launch(device_, items_, work_group_));
}

double CutExact::take_seconds() {
  const std::vector<double> seconds = cl::take_seconds(events_);
  return std::accumulate(seconds.begin(), seconds.end(), 0.0);
}

}  // namespace reamsim
