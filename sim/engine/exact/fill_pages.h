#pragma once

#include "sim/engine/common/device_bricks.h"

namespace reamsim {

/// The fill of bricks that are not whole, on the device: a page of 512 fills each, in the order in which they were
/// first cut.
struct FillPages {
  cl::Buffer<cl_int> page_of_slot;   ///< of the bricks; -1: whole
  cl::Buffer<cl_uint> slot_of_page;  ///< per page
  cl::Buffer<cl_ushort> fills;       ///< by rs_brick_offset within a page
  std::size_t used = 0;              ///< pages

  [[nodiscard]] std::size_t bytes() const { return page_of_slot.bytes() + slot_of_page.bytes() + fills.bytes(); }
  [[nodiscard]] std::size_t room() const { return slot_of_page.count(); }
};

/// The pages of `voxmap`'s bricks that are not whole.
FillPages make_fill_pages(const cl::Device& device, const BoneView& bone);

/// Makes room for `pages` pages in all, or for one for each brick where these are fewer. Throws RunError, with the
/// voxel size from which on they would fit, when the device has no room.
void reserve_pages(const cl::Device& device, std::size_t pages, double voxel_mm, FillPages& fill);

/// Puts the pages' fill into `fill`.
void read_pages(const cl::Device& device, const DeviceBricks& bricks, const FillPages& pages, FillBricks& fill);

/// The most device memory that the pages of `bricks` bricks take while reserve_pages() makes room for `pages`, bytes.
std::size_t fill_pages_bytes(std::size_t bricks, std::size_t pages);

}  // namespace reamsim
