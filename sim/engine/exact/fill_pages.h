// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/engine/common/device_bricks.h"

namespace reamsim {

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

}  // namespace reamsim
