#include "sim/engine/bricked/bricked_state.h"

#include <algorithm>

namespace reamsim {

namespace {

/// Of the lists of touched bricks and of the shell.
std::size_t bytes_beside_bone(const BoneView& bone, const Tool& tool) {
  return 2 * sizeof(cl_uint) * bone.voxmap.grade.stored_bricks() + 3 * tool.shell.codes.size();
}

}  // namespace

std::size_t bricked_bytes(const BoneView& bone, const Tool& tool, FillStore fill) {
  return device_bricks_bytes(bone, fill) + bytes_beside_bone(bone, tool);
}

BrickedState make_bricked_state(const cl::Device& device, const BoneView& bone, const Tool& tool, FillStore fill,
                                std::size_t largest_pool) {
  BrickedState state;
  state.bone = make_device_bricks(device, bone, fill, bytes_beside_bone(bone, tool), largest_pool);
  const std::size_t slots = std::max<std::size_t>(1, state.bone.layout.bricks);
  state.listed = {device, slots, "the marks of touched bricks"};
  state.listed.clear(device, slots);
  state.touched_list = {device, slots, "the list of touched bricks"};
  const ShellCells shell =
      make_shell_cells(tool.shell, shell_cell_side(tool.shell.cell_mm / bone.voxmap.grid.voxel_mm));
  state.cells = cl::upload(device, shell.cells, "the shell's cells");
  state.runs = cl::upload(device, shell.runs, "the shell's cells");
  state.offsets = cl::upload(device, shell.offsets, "the point shell");
  state.profile = {device, make_profile_table(tool.profile, bone.voxmap.grid.voxel_mm)};
  return state;
}

}  // namespace reamsim
