#include "sim/collide/fill_pages.h"

#include <algorithm>
#include <array>

namespace reamsim {

namespace {

constexpr std::size_t kLeastRoom = 64;  // pages

std::size_t bricks_with_fill(const Voxmap& voxmap) {
  std::size_t count = 0;
  voxmap.fill.for_each_brick(
      [&](const Vec3i& coord, const FillBricks::Brick&) { count += voxmap.grade.brick(coord) != nullptr ? 1 : 0; });
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

FillPages make_fill_pages(const cl::Device& device, const Voxmap& voxmap) {
  FillPages fill;
  fill.used = bricks_with_fill(voxmap);
  const std::size_t room = std::max(kLeastRoom, fill.used);
  std::vector<cl_int> page_of_slot;
  std::vector<cl_uint> slot_of_page;
  std::vector<cl_ushort> fills;
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
    const FillBricks::Brick* brick = voxmap.fill.brick(coord);
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

void reserve_pages(const cl::Device& device, std::size_t pages, FillPages& fill) {
  if (pages <= fill.room()) return;
  const std::size_t largest = device.info().max_allocation_bytes / (sizeof(cl_ushort) * RS_BRICK_VOXELS);
  // Half as much again, so that a growing cut does not move its pages at every visit.
  const std::size_t room = std::max(pages, std::min(largest, fill.room() + fill.room() / 2));
  fill.slot_of_page = grown(device, fill.slot_of_page, room, fill.used, "the table of fill");
  fill.fills = grown(device, fill.fills, room * RS_BRICK_VOXELS, fill.used * RS_BRICK_VOXELS, "the fill of cut bricks");
}

void read_pages(const cl::Device& device, const BrickedState& state, const FillPages& fill, Voxmap& voxmap) {
  if (fill.used == 0) return;
  constexpr std::size_t kChunk = 1024;  // pages read at once
  std::vector<cl_uint> slots(fill.used), lattice(state.lattice_of_slot.count());
  fill.slot_of_page.read(device, slots.data(), slots.size());
  state.lattice_of_slot.read(device, lattice.data(), lattice.size());
  const BrickLattice bricks = BrickLattice::over(voxmap.grid.dims);
  std::vector<cl_ushort> pages(kChunk * RS_BRICK_VOXELS);
  for (std::size_t first = 0; first < fill.used; first += kChunk) {
    const std::size_t count = std::min(kChunk, fill.used - first);
    fill.fills.read(device, pages.data(), count * RS_BRICK_VOXELS, first * RS_BRICK_VOXELS);
    for (std::size_t page = 0; page < count; ++page) {
      const cl_ushort* from = pages.data() + page * RS_BRICK_VOXELS;
      FillBricks::Brick brick{};
      for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
        const Vec3i voxel = BrickLattice::voxel_at(Vec3i::Zero(), offset);
        brick[static_cast<std::size_t>(offset)] = from[rs_brick_offset(voxel.x(), voxel.y(), voxel.z())];
      }
      voxmap.fill.put(bricks.coord(lattice[slots[first + page]]), brick);
    }
  }
}

std::size_t fill_pages_bytes(const Voxmap& voxmap) {
  return sizeof(cl_int) * voxmap.grade.stored_bricks() +
         std::max(kLeastRoom, bricks_with_fill(voxmap)) * (sizeof(cl_uint) + sizeof(cl_ushort) * RS_BRICK_VOXELS);
}

}  // namespace reamsim
