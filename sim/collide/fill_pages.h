#pragma once

#include "sim/collide/bricked_state.h"

namespace reamsim {

/// The fill of bricks that are not whole, on the device: a page of 512 fills each, in the order in which they were
/// first cut.
struct FillPages {
  cl::Buffer<cl_int> page_of_slot;   ///< of the bricks; -1: whole
  cl::Buffer<cl_uint> slot_of_page;  ///< per page
  cl::Buffer<cl_ushort> fills;       ///< by rs_brick_offset within a page
  std::size_t used = 0;              ///< pages

  [[nodiscard]] std::size_t room() const { return slot_of_page.count(); }
};

/// The pages of `voxmap`'s bricks that are not whole.
FillPages make_fill_pages(const cl::Device& device, const Voxmap& voxmap);

/// Makes room for `pages` pages in all; RunError when the device has none.
void reserve_pages(const cl::Device& device, std::size_t pages, FillPages& fill);

/// Puts the pages' fill into the voxmap.
void read_pages(const cl::Device& device, const BrickedState& state, const FillPages& fill, Voxmap& voxmap);

/// Device memory that make_fill_pages() would take, bytes.
std::size_t fill_pages_bytes(const Voxmap& voxmap);

}  // namespace reamsim
