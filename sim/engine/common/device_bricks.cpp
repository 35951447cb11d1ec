// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/device_bricks.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <set>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

static_assert(FillBricks::kSide == RS_BRICK_SIDE);

namespace {

constexpr int kManyPools = 16;
constexpr std::size_t kFillBytes = sizeof(rs_u16) * RS_BRICK_VOXELS;

/// The place in a brick of the device of the voxel with that offset on the host.
std::size_t device_place(int offset) {
  return static_cast<std::size_t>(rs_brick_offset(offset & 7, offset >> 3 & 7, offset >> 6));
}

/// Writes a brick in the device's layout. Returns whether it has bone.
bool write_brick(const BoneView& bone, const Vec3i& coord, const GradeBricks::Brick& grades, bool with_fill,
                 cl_uchar* bytes) {
  Brick out{};
  std::array<rs_u16, RS_BRICK_VOXELS> fill{};
  const FillBricks::Brick* fills = bone.fill.brick(coord);
  bool has_bone = false;
  for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
    const std::size_t place = device_place(offset);
    const auto at = static_cast<std::size_t>(offset);
    out.grade[place] = grades[at];
    fill[place] = fills == nullptr ? FillBricks::kWhole : (*fills)[at];
    if (out.grade[place] == 0 || fill[place] == 0) continue;
    out.bone[place >> 5] |= 1U << (place & 31U);
    has_bone = true;
  }
  std::memcpy(bytes, &out, sizeof out);
  if (with_fill) std::memcpy(bytes + sizeof out, fill.data(), kFillBytes);
  return has_bone;
}

/// Sets the bit of a brick with bone, in the layout of kernels/brick_report.h.
void set_occupied(const Vec3i& brick, const BrickLattice& superbricks, std::vector<cl_uint>& occupancy) {
  const std::size_t word = 2 * superbricks.index(brick / 4);
  const auto bit = static_cast<unsigned>((brick.x() & 3) | (brick.y() & 3) << 2 | (brick.z() & 3) << 4);
  occupancy[word + (bit >> 5)] |= 1U << (bit & 31U);
}

BrickLayout plan_layout(const BoneView& bone, FillStore fill, std::size_t largest_allocation) {
  BrickLayout layout;
  layout.fill = fill == FillStore::none && partly_filled(bone.fill) ? FillStore::bricks : fill;
  layout.brick_bytes = sizeof(Brick) + (layout.fill == FillStore::bricks ? kFillBytes : 0);
  layout.bricks = bone.voxmap.grade.stored_bricks();
  layout.bits = 31;
  if (layout.bricks * layout.brick_bytes <= largest_allocation) return layout;
  layout.pools = kManyPools;
  layout.bits = std::max(0, static_cast<int>(std::bit_width(largest_allocation / layout.brick_bytes)) - 1);
  return layout;
}

std::size_t bytes_of(const BrickLayout& layout, const BoneView& bone) {
  const std::size_t bricks = BrickLattice::over(bone.voxmap.grid.dims).count();
  return layout.bricks * (layout.brick_bytes + sizeof(cl_uint)) + bricks * sizeof(cl_int) +
         8 * superbricks_of(bone.voxmap.grade.brick_dims()).count();
}

[[noreturn]] void does_not_fit(const cl::Device& device, const BoneView& bone, std::size_t need, std::size_t have) {
  const double factor = std::cbrt(static_cast<double>(need) / static_cast<double>(have));
  throw InputError(
      {}, "bone.voxel_mm",
      "the bone's bricks need " + megabytes(need) + " of the " + megabytes(have) + " of " + device.info().name,
      "about " + std::to_string(bone.voxmap.grid.voxel_mm * std::max(1.0, factor) * 1.05) + " mm would fit");
}

constexpr std::size_t kMinRoom = 64;  // pages

/// 1.5 times the need, so that a growing cut does not move its pages at every visit.
std::size_t most_room(std::size_t needed) {
  return needed + needed / 2;
}

[[noreturn]] void pages_do_not_fit(const cl::Device& device, std::size_t pages, std::size_t largest, double voxel_mm) {
  const double factor = std::cbrt(static_cast<double>(pages) / static_cast<double>(std::max<std::size_t>(1, largest)));
  throw RunError(fmt::format(
      "the fill of cut bricks needs {} in one allocation, but {} supports at most {}; bone.voxel_mm of {:.3g} or more "
      "would fit, or a smaller crop",
      megabytes(pages * kFillBytes), device.info().name, megabytes(largest * kFillBytes), 1.05 * factor * voxel_mm));
}

template <class T>
cl::Buffer<T> grown(const cl::Device& device, const cl::Buffer<T>& old, std::size_t count, std::size_t used,
                    const char* what) {
  cl::Buffer<T> out(device, count, what);
  if (used > 0) out.copy(device, old, used);
  return out;
}

}  // namespace

std::vector<cl_mem> DeviceBricks::pool_arguments() const {
  std::vector<cl_mem> out;
  for (const auto& pool : pools) out.push_back(pool.get());
  out.resize(static_cast<std::size_t>(layout.pools), out.back());  // unused, but an argument must be a buffer
  return out;
}

std::size_t DeviceBricks::bytes() const {
  std::size_t out = slot_of_brick.bytes() + lattice_of_slot.bytes() + occupancy.bytes();
  for (const auto& pool : pools) out += pool.bytes();
  return out;
}

std::size_t device_bricks_bytes(const BoneView& bone, FillStore fill) {
  return bytes_of(plan_layout(bone, fill, SIZE_MAX), bone);
}

DeviceBricks make_device_bricks(const cl::Device& device, const BoneView& bone, FillStore fill, std::size_t other_bytes,
                                std::size_t largest_pool) {
  const std::size_t largest = std::min(device.info().max_allocation_bytes, largest_pool);
  DeviceBricks out;
  out.layout = plan_layout(bone, fill, largest);
  const std::size_t need = bytes_of(out.layout, bone) + other_bytes;
  if (need > device.info().global_memory_bytes) {
    does_not_fit(device, bone, need, device.info().global_memory_bytes);
  }
  const std::size_t room = largest < out.layout.brick_bytes ? 0 : std::size_t{kManyPools} << out.layout.bits;
  if (out.layout.pools > 1 && out.layout.bricks > room) {
    does_not_fit(device, bone, out.layout.bricks * out.layout.brick_bytes,
                 out.layout.brick_bytes * kManyPools << out.layout.bits);
  }

  const Vec3i bricks = bone.voxmap.grade.brick_dims();
  out.grid = bone.voxmap.grid;
  out.dims = {{bricks.x(), bricks.y(), bricks.z(), 0}};
  std::vector<cl_int> slot_of_brick(BrickLattice::over(bone.voxmap.grid.dims).count(), -1);
  std::vector<cl_uint> lattice_of_slot;
  const BrickLattice lattice{bricks};
  for_each_slot(bone.voxmap.grade, [&](const Vec3i& coord, const GradeBricks::Brick&) {
    const std::size_t index = lattice.index(coord);
    slot_of_brick[index] = static_cast<cl_int>(lattice_of_slot.size());
    lattice_of_slot.push_back(static_cast<cl_uint>(index));
  });
  out.slot_of_brick = cl::upload(device, slot_of_brick, "the table of bricks");
  out.lattice_of_slot = cl::upload(device, lattice_of_slot, "the bricks' places");
  const std::size_t per_pool = out.layout.pools == 1 ? out.layout.bricks : std::size_t{1} << out.layout.bits;
  for (std::size_t first = 0; first == 0 || first < out.layout.bricks; first += per_pool) {
    const std::size_t count = std::max<std::size_t>(1, std::min(per_pool, out.layout.bricks - first));
    out.pools.emplace_back(device, count * out.layout.brick_bytes, "the bone's bricks");
    if (per_pool == 0) break;
  }
  out.occupancy = {device, 2 * superbricks_of(bricks).count(), "the bricks' occupancy"};
  upload_bone(device, bone, out);
  return out;
}

void upload_bone(const cl::Device& device, const BoneView& bone, DeviceBricks& out) {
  const bool same = bone.voxmap.grid.dims == out.grid.dims && bone.voxmap.grade.stored_bricks() == out.layout.bricks &&
                    (out.layout.fill != FillStore::none || !partly_filled(bone.fill));
  if (!same) throw RunError("this is not the bone for which the engine was created");
  constexpr std::size_t kChunk = 4096;  // bricks written at once
  const std::size_t bytes = out.layout.brick_bytes;
  std::vector<cl_uchar> chunk(kChunk * bytes);
  std::vector<cl_uint> occupancy(out.occupancy.count(), 0);
  const BrickLattice superbricks = superbricks_of(bone.voxmap.grade.brick_dims());
  std::size_t slot = 0, first = 0;
  const auto flush = [&] {
    if (slot > first) {
      out.pools[out.layout.pool_of(first)].write(device, chunk.data(), (slot - first) * bytes,
                                                 out.layout.place_in_pool(first) * bytes);
    }
    first = slot;
  };
  for_each_slot(bone.voxmap.grade, [&](const Vec3i& brick, const GradeBricks::Brick& grades) {
    if (write_brick(bone, brick, grades, out.layout.fill == FillStore::bricks, chunk.data() + (slot - first) * bytes)) {
      set_occupied(brick, superbricks, occupancy);
    }
    ++slot;
    if (slot - first == kChunk || out.layout.place_in_pool(slot) == 0) flush();
  });
  flush();
  out.occupancy.write(device, occupancy.data(), occupancy.size());
}

void upload_bricks_of(const cl::Device& device, const BoneView& bone, const RemovedFrames& voxels, DeviceBricks& out) {
  if (voxels.empty()) return;
  const BrickLattice lattice = BrickLattice::over(bone.voxmap.grid.dims);
  std::set<std::size_t> touched;
  for (const auto& [voxel, frame] : voxels) {
    touched.insert(lattice.index(BrickLattice::brick_of(bone.voxmap.grid.coord(voxel))));
  }
  const std::size_t bytes = out.layout.brick_bytes;
  const BrickLattice superbricks = superbricks_of(lattice.dims);
  std::vector<cl_int> slots(out.slot_of_brick.count());
  std::vector<cl_uint> occupancy(out.occupancy.count());
  out.slot_of_brick.read(device, slots.data(), slots.size());
  out.occupancy.read(device, occupancy.data(), occupancy.size());
  std::vector<cl_uchar> record(bytes);
  for (const std::size_t index : touched) {
    const Vec3i brick = lattice.coord(index);
    const auto slot = static_cast<std::size_t>(slots[index]);
    const bool has_bone =
        write_brick(bone, brick, *bone.voxmap.grade.brick(brick), out.layout.fill == FillStore::bricks, record.data());
    out.pools[out.layout.pool_of(slot)].write(device, record.data(), bytes, out.layout.place_in_pool(slot) * bytes);
    if (has_bone) set_occupied(brick, superbricks, occupancy);
  }
  out.occupancy.write(device, occupancy.data(), occupancy.size());
}

void read_brick_fill(const cl::Device& device, const DeviceBricks& out, const Voxmap& voxmap, FillBricks& remaining) {
  if (out.layout.fill != FillStore::bricks) return;
  const std::size_t bytes = out.layout.brick_bytes;
  std::vector<cl_uchar> record(bytes);
  std::array<rs_u16, RS_BRICK_VOXELS> fill{};
  std::size_t slot = 0;
  for_each_slot(voxmap.grade, [&](const Vec3i& brick, const GradeBricks::Brick& grades) {
    out.pools[out.layout.pool_of(slot)].read(device, record.data(), bytes, out.layout.place_in_pool(slot) * bytes);
    std::memcpy(fill.data(), record.data() + sizeof(Brick), kFillBytes);
    ++slot;
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      if (grades[static_cast<std::size_t>(offset)] == 0) continue;
      remaining.set(BrickLattice::voxel_at(brick, offset), fill[device_place(offset)]);
    }
  });
}

FillPages make_fill_pages(const cl::Device& device, const BoneView& bone) {
  FillPages fill;
  std::vector<cl_int> page_of_slot;
  std::vector<cl_uint> slot_of_page;
  std::vector<cl_ushort> fills;
  for_each_slot(bone.voxmap.grade, [&](const Vec3i& coord, const GradeBricks::Brick&) {
    const FillBricks::Brick* brick = bone.fill.brick(coord);
    const auto slot = static_cast<cl_uint>(page_of_slot.size());
    page_of_slot.push_back(brick == nullptr ? -1 : static_cast<cl_int>(slot_of_page.size()));
    if (brick == nullptr) return;
    slot_of_page.push_back(slot);
    fills.resize(fills.size() + RS_BRICK_VOXELS);
    cl_ushort* page = fills.data() + fills.size() - RS_BRICK_VOXELS;
    for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
      page[device_place(offset)] = (*brick)[static_cast<std::size_t>(offset)];
    }
  });
  fill.used = slot_of_page.size();
  const std::size_t room = std::max(kMinRoom, fill.used);
  fill.page_of_slot = cl::upload(device, page_of_slot, "the table of fill");
  fill.slot_of_page = {device, room, "the table of fill"};
  fill.fills = {device, room * RS_BRICK_VOXELS, "the fill of cut bricks"};
  if (fill.used > 0) {
    fill.slot_of_page.write(device, slot_of_page.data(), slot_of_page.size());
    fill.fills.write(device, fills.data(), fills.size());
  }
  return fill;
}

void reserve_pages(const cl::Device& device, std::size_t pages, double voxel_mm, FillPages& fill) {
  const std::size_t bricks = fill.page_of_slot.count();
  const std::size_t needed = std::min(pages, bricks);
  if (needed <= fill.room()) return;
  const std::size_t largest = device.info().max_allocation_bytes / kFillBytes;
  if (needed > largest) pages_do_not_fit(device, needed, largest, voxel_mm);
  const std::size_t room = std::min({most_room(needed), bricks, largest});
  fill.slot_of_page = grown(device, fill.slot_of_page, room, fill.used, "the table of fill");
  fill.fills = grown(device, fill.fills, room * RS_BRICK_VOXELS, fill.used * RS_BRICK_VOXELS, "the fill of cut bricks");
}

void read_pages(const cl::Device& device, const DeviceBricks& bricks, const FillPages& pages, FillBricks& fill) {
  if (pages.used == 0) return;
  constexpr std::size_t kChunk = 1024;  // pages read at once
  std::vector<cl_uint> slots(pages.used), places(bricks.lattice_of_slot.count());
  pages.slot_of_page.read(device, slots.data(), slots.size());
  bricks.lattice_of_slot.read(device, places.data(), places.size());
  const BrickLattice lattice = BrickLattice::over(bricks.grid.dims);
  std::vector<cl_ushort> chunk(kChunk * RS_BRICK_VOXELS);
  for (std::size_t first = 0; first < pages.used; first += kChunk) {
    const std::size_t count = std::min(kChunk, pages.used - first);
    pages.fills.read(device, chunk.data(), count * RS_BRICK_VOXELS, first * RS_BRICK_VOXELS);
    for (std::size_t page = 0; page < count; ++page) {
      const cl_ushort* from = chunk.data() + page * RS_BRICK_VOXELS;
      FillBricks::Brick brick{};
      for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
        brick[static_cast<std::size_t>(offset)] = from[device_place(offset)];
      }
      fill.put(lattice.coord(places[slots[first + page]]), brick);
    }
  }
}

std::size_t fill_pages_bytes(std::size_t bricks, std::size_t pages) {
  const std::size_t needed = std::min(bricks, pages), room = std::max(kMinRoom, std::min(bricks, most_room(needed)));
  // While the buffer grows the old pages exist as well.
  return sizeof(cl_int) * bricks + (room + needed) * (sizeof(cl_uint) + kFillBytes);
}

KernelOptions choose_options(const cl::DeviceInfo& info, const EngineTuning& tuning) {
  KernelOptions options;
  const bool gpu =
      tuning.kernel_shape == KernelShape::gpu || (tuning.kernel_shape == KernelShape::automatic && info.gpu);
  options.shape = gpu ? KernelShape::gpu : KernelShape::cpu;
  // On a CPU every work-item is long, and PoCL hands whole groups to threads; on a GPU a cell has some hundred points.
  const std::size_t wanted = tuning.work_group_size > 0 ? static_cast<std::size_t>(tuning.work_group_size)
                             : gpu                      ? 128
                                                        : 1;
  options.work_group = std::min(wanted, info.max_work_group);
  options.culling = tuning.culling;
  return options;
}

std::size_t cut_items(const cl::DeviceInfo& info, const KernelOptions& options) {
  constexpr std::size_t kItemsPerCore = 8, kGroupsPerUnit = 32;
  return info.compute_units * (options.shape == KernelShape::cpu ? kItemsPerCore : kGroupsPerUnit * options.work_group);
}

std::string kernel_defines(const BrickLayout& layout, KernelShape shape) {
  return fmt::format("-DRS_POOLS={} -DRS_POOL_BITS={}{}{}", layout.pools, layout.bits,
                     layout.fill == FillStore::bricks ? " -DRS_BRICK_FILL" : "",
                     shape == KernelShape::cpu ? " -DRS_CPU_SHAPE" : "");
}

std::string cut_defines(const BrickLayout& layout, KernelShape shape) {
  return kernel_defines(layout, shape) + (shape == KernelShape::cpu ? " -DRS_LANES=16" : "");
}

}  // namespace reamsim
