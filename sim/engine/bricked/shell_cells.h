#pragma once

#include <vector>

#include "kernels/bricks.h"
#include "sim/tool/point_shell.h"

namespace reamsim {

/// The shell's points in cells with bounds, and runs of cells with bounds, both along the Morton curve.
struct ShellCells {
  std::vector<ShellCell> cells;
  std::vector<ShellCell> runs;         ///< kRunCells cells each, the last one fewer; begin and count are of cells
  std::vector<std::uint16_t> offsets;  ///< of the points; each cell's padded to a multiple of 16 by its last point
};

/// Cells that a run holds, and that a work-item of the CPU kernel takes.
inline constexpr int kRunCells = 64;

/// Longest side of a shell cell's block, in shell cells, whose points stay within the kernel's window of 32×32×32
/// voxels however they are turned: a power of two up to 32.
int shell_cell_side(double shell_cell_voxels);

/// Groups the points into blocks of `side`³ shell cells.
ShellCells make_shell_cells(const PointShell& shell, int side);

}  // namespace reamsim
