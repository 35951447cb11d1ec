// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/bricked/bricked_state.h"

#include <algorithm>
#include <array>

#include "kernels/cut_law.h"

namespace reamsim {

namespace {

/// The lists of touched bricks, and the shell.
std::size_t bytes_beside_bone(const BoneView& bone, const Tool& tool) {
  return 2 * sizeof(cl_uint) * bone.voxmap.grade.stored_bricks() + 3 * tool.shell.codes.size();
}

std::array<cl_ulong, 256> bits_of_byte() {
  std::array<cl_ulong, 256> out{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    int at = 0;
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((byte >> bit & 1U) != 0) out[byte] |= cl_ulong{bit} << (8 * at++);
    }
  }
  return out;
}

}  // namespace

std::size_t bricked_bytes(const BoneView& bone, const Tool& tool, FillStore fill) {
  return device_bricks_bytes(bone, fill) + bytes_beside_bone(bone, tool);
}

BrickedState make_bricked_state(const cl::Device& device, const BoneView& bone, const Tool& tool,
                                const EnergyTable& energy, FillStore fill, std::size_t largest_pool) {
  BrickedState state;
  state.bone = make_device_bricks(device, bone, fill, bytes_beside_bone(bone, tool), largest_pool);
  const std::size_t slots = std::max<std::size_t>(1, state.bone.layout.bricks);
  state.listed = {device, slots, "the marks of touched bricks"};
  state.listed.clear(device, slots);
  state.touched_list = {device, slots, "the list of touched bricks"};
  const ShellCells shell =
      make_shell_cells(tool.shell, shell_cell_side(tool.shell.cell_mm / bone.voxmap.grid.voxel_mm));
  state.cells = cl::upload(device, shell.cells, "the shell's cells", "tool.shell_resolution");
  state.runs = cl::upload(device, shell.runs, "the shell's cells", "tool.shell_resolution");
  state.offsets = cl::upload(device, shell.offsets, "the point shell", "tool.shell_resolution");
  state.outline = {device, make_outline_table(tool.profile, bone.voxmap.grid.voxel_mm)};
  std::array<rs_i64, 256> units{};
  std::ranges::transform(energy.energy_mj, units.begin(), rs_energy_units);
  state.energy_of_grade = cl::upload(device, energy.energy_mj, "the energy table");
  state.units_of_grade = cl::upload(device, units, "the energy table");
  state.density_of_grade = cl::upload(device, energy.density_g_cm3, "the density table");
  state.bits_of_byte = cl::upload(device, bits_of_byte(), "the table of bits");
  return state;
}

}  // namespace reamsim
