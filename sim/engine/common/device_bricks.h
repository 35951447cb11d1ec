// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kernels/bricks.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/device/opencl.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Storage of the fill of partly removed voxels.
enum class FillStore {
  none,    ///< voxels are whole or removed
  bricks,  ///< in every brick (`wear`, and bone that was reamed before)
  pages    ///< in pages, for partly removed bricks (`exact`)
};

/// Distribution of the bricks over buffers that the device can allocate.
struct BrickLayout {
  int pools = 1;  ///< 1, or 16
  int bits = 0;   ///< log2 of the bricks per pool
  std::size_t bricks = 0;
  std::size_t brick_bytes = 0;
  FillStore fill = FillStore::none;

  [[nodiscard]] std::size_t pool_of(std::size_t slot) const { return slot >> bits; }
  [[nodiscard]] std::size_t place_in_pool(std::size_t slot) const { return slot & ((std::size_t{1} << bits) - 1); }
};

/// The bone on the device: bricks of 8×8×8 voxels where there is bone, and their tables.
struct DeviceBricks {
  BrickLayout layout;
  VoxelGrid grid;                           ///< of the voxmap
  cl_int4 dims{};                           ///< bricks of the lattice, along each axis
  std::vector<cl::Buffer<cl_uchar>> pools;  ///< `Brick` of kernels/bricks.h
  cl::Buffer<cl_int> slot_of_brick;         ///< -1: no bone
  cl::Buffer<cl_uint> lattice_of_slot;
  cl::Buffer<cl_uint> occupancy;  ///< two words per 4×4×4 bricks: a bit per brick with bone

  /// The pools as arguments of a kernel.
  [[nodiscard]] std::vector<cl_mem> pool_arguments() const;
  [[nodiscard]] std::size_t bytes() const;
};

/// The lattice of superbricks of 4×4×4 bricks.
inline BrickLattice superbricks_of(const Vec3i& bricks) {
  return {(bricks.array() + 3) / 4};
}

/// Calls visit(brick coordinates, grades) for every stored brick in the order of the slots: superbrick by superbrick
/// (4×4×4 bricks), x fastest. The bricks that a surface meets then lie in few pages of memory.
template <class Visit>
void for_each_slot(const GradeBricks& grades, const Visit& visit) {
  constexpr int kSide = 4;
  const BrickLattice superbricks = superbricks_of(grades.brick_dims());
  for (std::size_t s = 0; s < superbricks.count(); ++s) {
    const Vec3i first = kSide * superbricks.coord(s);
    for (int bit = 0; bit < kSide * kSide * kSide; ++bit) {
      const Vec3i coord = first + Vec3i(bit & 3, bit >> 2 & 3, bit >> 4);
      const auto* brick = grades.lattice().contains(coord) ? grades.brick(coord) : nullptr;
      if (brick != nullptr) visit(coord, *brick);
    }
  }
}

/// Uploads the bone. A buffer of bricks has at most `largest_pool` bytes. `other_bytes`: further memory of the engine.
/// Throws InputError with the voxel size that would fit, before it allocates.
DeviceBricks make_device_bricks(const cl::Device& device, const BoneView& bone, FillStore fill, std::size_t other_bytes,
                                std::size_t largest_pool = SIZE_MAX);

/// Device memory of make_device_bricks(), bytes.
std::size_t device_bricks_bytes(const BoneView& bone, FillStore fill);

/// Uploads the bone again. Throws RunError where its bricks are not those that `bricks` was made with.
void upload_bone(const cl::Device& device, const BoneView& bone, DeviceBricks& bricks);

/// As upload_bone(), for the bricks of these voxels (VoxelGrid::index) only.
void upload_bricks_of(const cl::Device& device, const BoneView& bone, const RemovedFrames& voxels,
                      DeviceBricks& bricks);

/// Copies the fill of the bricks into `fill`.
void read_brick_fill(const cl::Device& device, const DeviceBricks& bricks, const Voxmap& voxmap, FillBricks& fill);

/// The fill of partly removed bricks on the device: a page of 512 fills each, in the order of their first cut.
struct FillPages {
  cl::Buffer<cl_int> page_of_slot;   ///< of the bricks; -1: whole
  cl::Buffer<cl_uint> slot_of_page;  ///< per page
  cl::Buffer<cl_ushort> fills;       ///< by rs_brick_offset within a page
  std::size_t used = 0;              ///< pages

  [[nodiscard]] std::size_t bytes() const { return page_of_slot.bytes() + slot_of_page.bytes() + fills.bytes(); }
  [[nodiscard]] std::size_t room() const { return slot_of_page.count(); }
};

/// The pages of the bone's partly removed bricks.
FillPages make_fill_pages(const cl::Device& device, const BoneView& bone);

/// Reserves `pages` pages in total, or one per brick if these are fewer. Throws RunError, with the voxel size that
/// would fit, when the device runs out of memory.
void reserve_pages(const cl::Device& device, std::size_t pages, double voxel_mm, FillPages& fill);

/// Copies the fill of the pages into `fill`.
void read_pages(const cl::Device& device, const DeviceBricks& bricks, const FillPages& pages, FillBricks& fill);

/// Bound of the device memory of the pages of `bricks` bricks during reserve_pages() for `pages`, bytes.
std::size_t fill_pages_bytes(std::size_t bricks, std::size_t pages);

/// How the kernels over bricks run; the results do not depend on it.
struct KernelOptions {
  KernelShape shape = KernelShape::cpu;  ///< not `automatic`; cpu: long work-items in vectors, gpu: many short ones
  std::size_t work_group = 1;
  bool culling = true;  ///< pass over cells that cannot touch; off only to prove that it changes nothing
};

/// What the tuning leaves open is chosen for the device.
KernelOptions choose_options(const cl::DeviceInfo& info, const EngineTuning& tuning);

/// Work-items that fill the device with a cut: on a CPU few that take many bricks each, on a GPU many groups.
std::size_t cut_items(const cl::DeviceInfo& info, const KernelOptions& options);

/// Options that kernels over bricks are compiled with, and those of the cuts.
std::string kernel_defines(const BrickLayout& layout, KernelShape shape);
std::string cut_defines(const BrickLayout& layout, KernelShape shape);

}  // namespace reamsim
