// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/exact/fill_pages.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr std::size_t kMinRoom = 64;  // pages
constexpr std::size_t kPageBytes = sizeof(cl_ushort) * RS_BRICK_VOXELS;

/// 1.5 times the need, so that a growing cut does not move its pages at every visit.
std::size_t most_room(std::size_t needed) {
  return needed + needed / 2;
}

[[noreturn]] void does_not_fit(const cl::Device& device, std::size_t pages, std::size_t largest, double voxel_mm) {
  const double factor = std::cbrt(static_cast<double>(pages) / static_cast<double>(std::max<std::size_t>(1, largest)));
  throw RunError(fmt::format(
      "the fill of cut bricks needs {} in one allocation, but {} supports at most {}; bone.voxel_mm of {:.3g} or more "
      "would fit, or a smaller crop",
      megabytes(pages * kPageBytes), device.info().name, megabytes(largest * kPageBytes), 1.05 * factor * voxel_mm));
}

std::size_t bricks_with_fill(const BoneView& bone) {
  std::size_t count = 0;
  bone.fill.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick&) {
    count += bone.voxmap.grade.brick(coord) != nullptr ? 1 : 0;
  });
  return count;
}

template <class T>
cl::Buffer<T> grown(const cl::Device& device, const cl::Buffer<T>& old, std::size_t count, std::size_t used,
                    const char* what) {
  cl::Buffer<T> out(device, count, what);
  if (used > 0) out.copy(device, old, used);
  return out;
}

}  // namespace

FillPages make_fill_pages(const cl::Device& device, const BoneView& bone) {
  FillPages fill;
  fill.used = bricks_with_fill(bone);
  const std::size_t room = std::max(kMinRoom, fill.used);
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
      const Vec3i voxel = BrickLattice::voxel_at(Vec3i::Zero(), offset);
      page[rs_brick_offset(voxel.x(), voxel.y(), voxel.z())] = (*brick)[static_cast<std::size_t>(offset)];
    }
  });
  fill.page_of_slot = {device, std::max<std::size_t>(1, page_of_slot.size()), "the table of fill"};
  if (!page_of_slot.empty()) fill.page_of_slot.write(device, page_of_slot.data(), page_of_slot.size());
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
  const std::size_t largest = device.info().max_allocation_bytes / kPageBytes;
  if (needed > largest) does_not_fit(device, needed, largest, voxel_mm);
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
        const Vec3i voxel = BrickLattice::voxel_at(Vec3i::Zero(), offset);
        brick[static_cast<std::size_t>(offset)] = from[rs_brick_offset(voxel.x(), voxel.y(), voxel.z())];
      }
      fill.put(lattice.coord(places[slots[first + page]]), brick);
    }
  }
}

std::size_t fill_pages_bytes(std::size_t bricks, std::size_t pages) {
  const std::size_t needed = std::min(bricks, pages), room = std::max(kMinRoom, std::min(bricks, most_room(needed)));
  // While the buffer grows the old pages exist as well.
  return sizeof(cl_int) * bricks + (room + needed) * (sizeof(cl_uint) + kPageBytes);
}

}  // namespace reamsim
