// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <vector>

#include "kernels/bricks.h"
#include "sim/tool/point_shell.h"

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

}  // namespace reamsim
