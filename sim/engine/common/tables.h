// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include "kernels/bricks.h"
#include "kernels/distance_grid.h"
#include "kernels/outline.h"
#include "sim/device/opencl.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/distance_grid.h"
#include "sim/tool/point_shell.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// Largest motion within a window of `exact`, rotation of resolved cutting edges included, voxels: every candidate
/// voxel of a window is tested in each of its substeps.
inline constexpr double kWindowShiftVoxels = 0.5;

/// The tool's outline as kernels read it: lines and arcs in (r, z), and for each cell near the surface the list of
/// those that can be nearest there (OutlineGrid in kernels/outline.h). The distance of a voxel then takes constant
/// time, whatever the length of the profile.
struct OutlineTable {
  std::vector<OutlinePiece> pieces;
  std::vector<rs_u16> numbers;  ///< of pieces, list after list, beginning with the list of all
  std::vector<PieceList> lists;
  OutlineGrid grid{};
  double bulge_mm = 0;  ///< largest distance of a piece from the profile's edges
};

inline OutlineView view_of(const OutlineTable& table) {
  return {table.pieces.data(), table.numbers.data(), table.lists.data(), &table.grid};
}

/// All pieces in one list: the reference. Corners count as sharp where the sections on both sides are at least as long
/// as a voxel, because two planes represent the outline there.
OutlineTable full_outline_table(const Profile& profile, double voxel_mm);

/// With lists for voxels of `voxel_mm`. Distances and normals are bitwise those of full_outline_table(). Throws
/// InputError beyond 65535 pieces.
OutlineTable make_outline_table(const Profile& profile, double voxel_mm);

/// A table on the device, four arguments of a kernel: pieces, numbers, lists, grid.
using DeviceOutline =
    std::tuple<cl::Buffer<OutlinePiece>, cl::Buffer<rs_u16>, cl::Buffer<PieceList>, cl::Buffer<OutlineGrid>>;
DeviceOutline upload_outline(const cl::Device& device, const OutlineTable& table);

/// The lattice of the distance grid as host and kernels read it.
DistanceLattice distance_lattice(const DistanceGrid& grid);

/// The distance grid of resolved cutting edges on the device, three arguments of a kernel: lattice, slots, samples.
using DeviceTeeth = std::tuple<cl::Buffer<DistanceLattice>, cl::Buffer<cl_uint>, cl::Buffer<float>>;
/// `bulge_mm`: largest distance of the tool's outline from its profile (kernels/outline.h). `bone_bytes`: device
/// memory of the bone. Throws InputError with the voxel size that would fit where the device has no room for both.
DeviceTeeth upload_teeth(const cl::Device& device, const DistanceGrid& grid, double voxel_mm, double bulge_mm,
                         std::size_t bone_bytes);

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

/// Energy to cut a whole voxel of bone of that density, mJ: u₀·(ρ/ρ_ref)^p, or interpolated in the scenario's table,
/// constant beyond its ends. Without the size effect.
double cutting_energy_mj(const CuttingSettings& cutting, double density_g_cm3, double voxel_mm);

/// Cutting energy of a whole voxel and density, by grade.
struct EnergyTable {
  std::array<double, 256> energy_mj{};
  std::array<rs_i64, 256> units{};    ///< the energy, in units of the energy sum
  std::array<rs_i32, 256> density{};  ///< RS_DENSITY_SCALE
};

EnergyTable make_energy_table(const CuttingSettings& cutting, double voxel_mm);

}  // namespace reamsim
