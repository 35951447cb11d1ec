#pragma once

#include "sim/engine/common/device_batch.h"
#include "sim/engine/dense/dense_state.h"
#include "sim/engine/dense/detection.h"

namespace reamsim {

/// The narrow phase of Zheng et al. on OpenCL, as Faieghi et al. (2020, §4.3.1) rebuilt it: one work-item per shell
/// point, three floats each, that descends the 3D grid through look-up tables. The state's layout is flagged_hu.
class DetectOctree final : public Detection {
 public:
  /// `per_point`: each point has a force of its own, and the forces of all points are reduced. `work_group` items per
  /// group, of which kMostPerGroup are used at most; the result does not depend on it.
  DetectOctree(const cl::Device& device, const DenseState& state, const DeviceBatch& batch, const PointShell& shell,
               const VoxelGrid& grid, bool per_point, std::size_t work_group);
  void enqueue(int slot) override;
  std::vector<double> take_seconds() override { return kernel_.take_seconds(); }

  /// The reduction keeps 48 bytes a work-item in local memory.
  static constexpr std::size_t kMostPerGroup = 256;

 private:
  /// The parameters of the kernel, in its order.
  enum class Argument : cl_uint {
    points,
    point_count,
    args,
    substep,
    hu,
    hu_of_air,
    flags,
    contacts,
    contact_count,
    sums,
    edges,
    numbers,
    lists,
    grid,
    children,
    levels
  };

  std::size_t count_;
  cl::Buffer<cl_float> points_;
  cl::Buffer<cl_uint4> children_;
  cl::SlotKernel kernel_;
};

/// Levels of the descent: the cube round the lattice has 2^levels voxels along a side.
int octree_levels(const VoxelGrid& grid);

/// The look-up tables of the descent: for octant o of a cell of level l, entry 8·l + o, where the child begins from
/// the cell's corner, in voxels, and (w) as a step in the dense array.
std::vector<cl_uint4> octree_children(const VoxelGrid& grid);

}  // namespace reamsim
