#include "sim/engine/serial/serial_state.h"

#include "sim/engine/common/dense_bone.h"

namespace reamsim {

SerialState make_serial_state(const Voxmap& voxmap, const Tool& tool) {
  SerialState state;
  state.tool = &tool;
  state.profile = full_profile_table(tool.profile);
  state.outline = full_outline_table(tool.profile, voxmap.grid.voxel_mm);
  if (tool.teeth) state.lattice = distance_lattice(*tool.teeth);
  take_bone(voxmap, state);
  return state;
}

void take_bone(const Voxmap& voxmap, SerialState& state) {
  state.grid = voxmap.grid;
  state.bone = dense_grades_left(voxmap);
  state.fill = dense_fill(voxmap);
}

}  // namespace reamsim
