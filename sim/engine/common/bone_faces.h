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

/// The faces of a bone on a device, as arguments of a kernel: their bricks by slot, the bricks, the faces.
using DeviceFaces = std::tuple<cl::Buffer<cl_int>, cl::Buffer<FaceBrick>, cl::Buffer<cl_int>>;
DeviceFaces upload_faces(const cl::Device& device, const BoneView& bone);

/// The surface of the bone before the run in the voxels that were partly filled (kernels/bone_face.h). The normal is
/// the gradient of the fraction of bone over 27 voxels (Parker and Youngs 1992, AWE report 01/92).
class BoneFaces {
 public:
  explicit BoneFaces(const BoneView& bone);

  /// The face of a voxel, or RS_NO_FACE.
  [[nodiscard]] rs_i32 at(const Vec3i& voxel) const;

 private:
  friend DeviceFaces upload_faces(const cl::Device& device, const BoneView& bone);
  BrickLattice lattice_;
  std::vector<rs_i32> number_of_brick_;  ///< in bricks_; -1: none
  std::vector<FaceBrick> bricks_;
  std::vector<rs_i32> faces_;
};

/// The device memory that DeviceFaces takes, bytes.
std::size_t bone_faces_bytes(const BoneView& bone);

}  // namespace reamsim
