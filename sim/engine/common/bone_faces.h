// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "kernels/bone_face.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/device/opencl.h"
#include "sim/engine/common/device_bricks.h"

namespace reamsim {

/// The face of a voxel with the fill `fill`, not 0 and not whole. `normal`: along the outward normal; zero where
/// unknown.
rs_i32 packed_face(std::uint16_t fill, const Eigen::Vector3f& normal);

/// The surface of the bone before the run in the voxels that were partly filled (kernels/bone_face.h). The normal is
/// the gradient of the fraction of bone over 27 voxels (Parker and Youngs 1992, AWE report 01/92).
class BoneFaces {
 public:
  explicit BoneFaces(const BoneView& bone);

  /// The face of a voxel, or RS_NO_FACE.
  [[nodiscard]] rs_i32 at(const Vec3i& voxel) const;

 private:
  friend class DeviceFaces;
  BrickLattice lattice_;
  std::vector<rs_i32> number_of_brick_;  ///< in bricks_; -1: none
  std::vector<FaceBrick> bricks_;
  std::vector<rs_i32> faces_;
};

/// The same on a device.
class DeviceFaces {
 public:
  DeviceFaces(const cl::Device& device, const BoneView& bone);

  /// As arguments of a kernel.
  [[nodiscard]] auto arguments() const { return std::tie(number_of_slot_, bricks_, faces_); }
  [[nodiscard]] std::size_t bytes() const { return number_of_slot_.bytes() + bricks_.bytes() + faces_.bytes(); }

 private:
  cl::Buffer<cl_int> number_of_slot_;
  cl::Buffer<FaceBrick> bricks_;
  cl::Buffer<cl_int> faces_;
};

/// Device memory of DeviceFaces, bytes.
std::size_t bone_faces_bytes(const BoneView& bone);

}  // namespace reamsim
