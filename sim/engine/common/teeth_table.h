#pragma once

#include "kernels/distance_grid.h"
#include "sim/device/opencl.h"
#include "sim/tool/distance_grid.h"

namespace reamsim {

/// The lattice of a tool's distance grid as host and kernels read it.
DistanceLattice distance_lattice(const DistanceGrid& grid);

/// A tool's distance grid on the device.
class DeviceTeeth {
 public:
  DeviceTeeth() = default;
  /// `bulge_mm`: furthest that the tool's outline lies from its profile (kernels/outline.h). Throws InputError that
  /// says which voxels would fit where the device has no room for it beside the `taken_bytes` that the bone takes.
  /// `voxel_mm`: of the bone.
  DeviceTeeth(const cl::Device& device, const DistanceGrid& grid, double voxel_mm, double bulge_mm,
              std::size_t taken_bytes);
  /// Sets three arguments: lattice, slots, samples.
  template <class Argument>
  void set(cl::Kernel& kernel, Argument first) const {
    kernel.set_from(first, lattice_, slots_, samples_);
  }

 private:
  cl::Buffer<DistanceLattice> lattice_;
  cl::Buffer<cl_uint> slots_;
  cl::Buffer<float> samples_;
};

}  // namespace reamsim
