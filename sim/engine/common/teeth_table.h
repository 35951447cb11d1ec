// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <tuple>

#include "kernels/distance_grid.h"
#include "sim/device/opencl.h"
#include "sim/tool/distance_grid.h"

namespace reamsim {

/// The lattice of the distance grid as host and kernels read it.
DistanceLattice distance_lattice(const DistanceGrid& grid);

/// The distance grid of resolved cutting edges on the device.
class DeviceTeeth {
 public:
  DeviceTeeth() = default;
  /// `bulge_mm`: largest distance of the tool's outline from its profile (kernels/outline.h). `bone_bytes`: device
  /// memory of the bone. Throws InputError with the voxel size that would fit where the device has no room for both.
  DeviceTeeth(const cl::Device& device, const DistanceGrid& grid, double voxel_mm, double bulge_mm,
              std::size_t bone_bytes);
  /// Three arguments of a kernel: lattice, slots, samples.
  [[nodiscard]] auto arguments() const { return std::tie(lattice_, slots_, samples_); }

 private:
  cl::Buffer<DistanceLattice> lattice_;
  cl::Buffer<cl_uint> slots_;
  cl::Buffer<float> samples_;
};

}  // namespace reamsim
