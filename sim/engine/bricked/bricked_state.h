#pragma once

#include <string>
#include <vector>

#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/device/opencl.h"
#include "sim/engine/bricked/shell_cells.h"
#include "sim/engine/common/profile_table.h"
#include "sim/scenario/choices.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// Where the fill of voxels that are partly gone stands.
enum class FillStore {
  none,    ///< voxels are whole or gone
  bricks,  ///< in every brick (`wear`, and bone that has been reamed before)
  pages    ///< in pages, of the bricks that are not whole (`exact`)
};

/// How the bricks are laid into buffers: none larger than the device allocates in one piece.
struct BrickPools {
  int pools = 1;  ///< 1, or 16
  int bits = 0;   ///< log2 of the bricks that a pool holds
  std::size_t bricks = 0;
  std::size_t brick_bytes = 0;
  FillStore fill = FillStore::none;

  /// Options that the kernels are compiled with.
  [[nodiscard]] std::string defines(KernelShape shape) const;
};

/// What `bricked` keeps on the device: bricks of 8×8×8 voxels where there is bone, the table that finds them, which of
/// them still hold bone, and the shell's points in cells.
struct BrickedState {
  BrickPools layout;
  VoxelGrid grid;                           ///< of the voxmap
  cl_int4 bricks{};                         ///< of the lattice, along each axis
  std::vector<cl::Buffer<cl_uchar>> pools;  ///< `Brick` of kernels/bricks.h
  cl::Buffer<cl_int> slot_of_brick;         ///< -1: no bone
  cl::Buffer<cl_uint> lattice_of_slot;
  cl::Buffer<cl_uint> occupancy;  ///< two words per 4×4×4 bricks
  cl::Buffer<cl_uint> listed;     ///< per slot
  cl::Buffer<cl_uint> touched_list;
  cl::Buffer<ShellCell> cells;
  cl::Buffer<ShellCell> runs;
  cl::Buffer<cl_ushort> offsets;
  DeviceProfile profile;

  /// Sets the pools' arguments from `first_argument` on.
  void set_pools(cl::Kernel& kernel, cl_uint first_argument) const;
};

/// Uploads bone and tool. No buffer of bricks takes more than `largest_pool` bytes, nor more than the device allocates
/// in one piece. Throws InputError that says what would fit; memory is planned before it is taken.
BrickedState make_bricked_state(const cl::Device& device, const Voxmap& voxmap, const Tool& tool, FillStore fill,
                                std::size_t largest_pool = SIZE_MAX);

/// Uploads the bone again, as `voxmap` has it. Its bricks must be those that the state was made with.
void upload_bone(const cl::Device& device, BrickedState& state, const Voxmap& voxmap);

/// As upload_bone(), for the bricks of these voxels (VoxelGrid::index) only.
void upload_bricks_of(const cl::Device& device, BrickedState& state, const Voxmap& voxmap, const RemovedFrames& voxels);

/// Puts every fill that differs from the voxmap's into it.
void read_bricked_fill(const cl::Device& device, const BrickedState& state, Voxmap& voxmap);

/// Device memory that make_bricked_state() would take, bytes.
std::size_t bricked_bytes(const Voxmap& voxmap, const Tool& tool, FillStore fill);

}  // namespace reamsim
