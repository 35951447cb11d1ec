// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "kernels/bricks.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/common/tables.h"
#include "sim/scenario/choices.h"
#include "sim/tool/point_shell.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// The shell's points in cells with bounds, and runs of cells with bounds, in Morton order.
struct ShellCells {
  std::vector<ShellCell> cells;
  std::vector<ShellCell> runs;         ///< kRunCells cells each, the last one fewer; begin and count refer to cells
  std::vector<std::uint16_t> offsets;  ///< of the points; padded per cell to a multiple of 16 by its last point
};

/// Cells of a run, which one work-item of the CPU kernel processes.
inline constexpr int kRunCells = 64;

/// Largest side of a block of shell cells whose points lie within the kernel's window of 32×32×32 voxels in any
/// orientation: a power of two up to 32.
int shell_cell_side(double shell_cell_voxels);

/// Groups the points into blocks of `side`³ shell cells.
ShellCells make_shell_cells(const PointShell& shell, int side);

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
