#pragma once

#include <string>
#include <vector>

#include "kernels/bricks.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/device/opencl.h"

namespace reamsim {

/// Where the fill of voxels that are partly removed stands.
enum class FillStore {
  none,    ///< voxels are whole or removed
  bricks,  ///< in every brick (`wear`, and bone that has been reamed before)
  pages    ///< in pages, of the bricks that are not whole (`exact`)
};

/// How the bricks are laid into buffers: none larger than the device allocates in one piece.
struct BrickLayout {
  int pools = 1;  ///< 1, or 16
  int bits = 0;   ///< log2 of the bricks that a pool holds
  std::size_t bricks = 0;
  std::size_t brick_bytes = 0;
  FillStore fill = FillStore::none;

  /// Options that the kernels are compiled with.
  [[nodiscard]] std::string defines() const;
};

/// The bone on the device: bricks of 8×8×8 voxels where there is bone, the table that finds them, and which of them
/// still hold bone.
struct DeviceBricks {
  BrickLayout layout;
  VoxelGrid grid;                           ///< of the voxmap
  cl_int4 dims{};                           ///< bricks of the lattice, along each axis
  std::vector<cl::Buffer<cl_uchar>> pools;  ///< `Brick` of kernels/bricks.h
  cl::Buffer<cl_int> slot_of_brick;         ///< -1: no bone
  cl::Buffer<cl_uint> lattice_of_slot;
  cl::Buffer<cl_uint> occupancy;  ///< two words per 4×4×4 bricks

  /// The pools as arguments of a kernel.
  [[nodiscard]] std::vector<cl_mem> pool_arguments() const;
  [[nodiscard]] std::size_t bytes() const;
};

/// Uploads the bone. No buffer of bricks takes more than `largest_pool` bytes, nor more than the device allocates in
/// one piece. `other_bytes`: what the engine is going to take beside. Throws InputError that says what would fit;
/// memory is planned before it is taken.
DeviceBricks make_device_bricks(const cl::Device& device, const BoneView& bone, FillStore fill, std::size_t other_bytes,
                                std::size_t largest_pool = SIZE_MAX);

/// Device memory that make_device_bricks() would take, bytes.
std::size_t device_bricks_bytes(const BoneView& bone, FillStore fill);

/// Uploads the bone again, as `voxmap` has it. Its bricks must be those that `bricks` was made with; else RunError.
void upload_bone(const cl::Device& device, const BoneView& bone, DeviceBricks& bricks);

/// As upload_bone(), for the bricks of these voxels (VoxelGrid::index) only.
void upload_bricks_of(const cl::Device& device, const BoneView& bone, const RemovedFrames& voxels,
                      DeviceBricks& bricks);

/// Puts every fill that the bricks hold into `fill`.
void read_brick_fill(const cl::Device& device, const DeviceBricks& bricks, const Voxmap& voxmap, FillBricks& fill);

}  // namespace reamsim
