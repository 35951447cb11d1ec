#pragma once

#include "sim/collide/exact_reach.h"
#include "sim/collide/fill_pages.h"
#include "sim/collide/outline_table.h"
#include "sim/collide/teeth_table.h"
#include "sim/cut/energy_table.h"

namespace reamsim {

/// `exact` over the bricks in reach; see kernels/cut_exact.cl.
class ExactCut {
 public:
  /// `teeth`: what clips instead of the profile; nullptr where the tool runs as its envelope.
  ExactCut(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch, const ExactReach& reach,
           const OutlineTable& outline, const EnergyTable& table, const BrickedOptions& options,
           const DeviceTeeth* teeth);

  /// Records of removed voxels that a visit can make at most.
  [[nodiscard]] static std::size_t most_records(std::size_t listed, int substeps);
  /// Enqueues a visit of the listed bricks; `fill` needs room for a page for each of them, `removed` for every record.
  void visit(const VisitPlan& plan, const FillPages& fill, const cl::Buffer<RemovedBlock>& removed);
  /// Seconds that the visits since the last call took.
  double take_seconds();

 private:
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
