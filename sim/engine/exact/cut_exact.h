#pragma once

#include "sim/engine/common/energy_table.h"
#include "sim/engine/common/kernel_options.h"
#include "sim/engine/common/outline_table.h"
#include "sim/engine/common/teeth_table.h"
#include "sim/engine/exact/fill_pages.h"
#include "sim/engine/exact/list_bricks.h"

namespace reamsim {

/// `exact` over the bricks in reach; see kernels/cut_exact.cl.
class CutExact {
 public:
  /// `teeth`: what clips instead of the profile; nullptr where the tool runs as its envelope.
  CutExact(const cl::Device& device, const DeviceBricks& bone, const DeviceBatch& batch, const ListBricks& list,
           const OutlineTable& outline, const EnergyTable& table, const KernelOptions& options,
           const DeviceTeeth* teeth);

  /// Records of removed voxels that a visit can make at most.
  [[nodiscard]] static std::size_t most_records(std::size_t listed, int substeps);
  /// Enqueues a visit of the listed bricks; `fill` needs room for a page for each of them, `removed` for every record.
  void enqueue(const VisitPlan& plan, const FillPages& fill, const cl::Buffer<RemovedBlock>& removed);
  /// Seconds that the visits since the last call took.
  double take_seconds();

 private:
  /// The parameters of the kernel, in its order.
  enum class Argument : cl_uint {
    args,
    windows,
    window_count,
    listed,
    counts,
    lattice_of_slot,
    occupancy,
    bricks,
    page_of_slot,
    slot_of_page,
    pages,
    sums,
    removed,
    energy_of_grade,
    pieces,
    numbers,
    lists,
    grid,
    lanes_of_item,
    pool_0
  };

  const cl::Device& device_;
  std::size_t items_;
  std::size_t work_group_;
  cl::Buffer<float> energy_;
  cl::Buffer<SubstepWindow> windows_;
  cl::Buffer<cl_long> lanes_;
  DeviceOutline outline_;
  cl::Kernel kernel_;
  std::vector<cl::Event> events_;
};

}  // namespace reamsim
