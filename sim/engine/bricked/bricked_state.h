// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/engine/bricked/shell_cells.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/common/energy_table.h"
#include "sim/engine/common/outline_table.h"
#include "sim/scenario/choices.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// The data of `bricked` on the device: the bone's bricks, the lists of those that a substep touches, the shell's
/// points in cells, and tables.
struct BrickedState {
  DeviceBricks bone;
  cl::Buffer<cl_uint> listed;  ///< per slot
  cl::Buffer<cl_uint> touched_list;
  cl::Buffer<ShellCell> cells;
  cl::Buffer<ShellCell> runs;
  cl::Buffer<cl_ushort> offsets;
  DeviceOutline outline;
  cl::Buffer<double> energy_of_grade;   ///< mJ
  cl::Buffer<rs_i64> units_of_grade;    ///< the same in units of the energy sum
  cl::Buffer<double> density_of_grade;  ///< g/cm³
  cl::Buffer<cl_ulong> bits_of_byte;    ///< per byte the numbers of its bits, a byte each, lowest first; then zeros

  [[nodiscard]] std::size_t shell_bytes() const { return cells.bytes() + runs.bytes() + offsets.bytes(); }
};

/// Uploads bone, tool and tables. Throws as make_device_bricks() does.
BrickedState make_bricked_state(const cl::Device& device, const BoneView& bone, const Tool& tool,
                                const EnergyTable& energy, FillStore fill, std::size_t largest_pool = SIZE_MAX);

/// Device memory of bone and tool in make_bricked_state(), bytes.
std::size_t bricked_bytes(const BoneView& bone, const Tool& tool, FillStore fill);

}  // namespace reamsim
