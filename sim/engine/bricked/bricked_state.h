#pragma once

#include "sim/engine/bricked/shell_cells.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/common/profile_table.h"
#include "sim/scenario/choices.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// What `bricked` keeps on the device: the bone's bricks, lists of those that a substep touches, and the shell's points
/// in cells.
struct BrickedState {
  DeviceBricks bone;
  cl::Buffer<cl_uint> listed;  ///< per slot
  cl::Buffer<cl_uint> touched_list;
  cl::Buffer<ShellCell> cells;
  cl::Buffer<ShellCell> runs;
  cl::Buffer<cl_ushort> offsets;
  DeviceProfile profile;

  [[nodiscard]] std::size_t shell_bytes() const { return cells.bytes() + runs.bytes() + offsets.bytes(); }
};

/// Uploads bone and tool; throws as make_device_bricks() does.
BrickedState make_bricked_state(const cl::Device& device, const BoneView& bone, const Tool& tool, FillStore fill,
                                std::size_t largest_pool = SIZE_MAX);

/// Device memory that make_bricked_state() would take, bytes.
std::size_t bricked_bytes(const BoneView& bone, const Tool& tool, FillStore fill);

}  // namespace reamsim
