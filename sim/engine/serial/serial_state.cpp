#include "sim/engine/serial/serial_state.h"

#include "sim/engine/common/dense_bone.h"

namespace reamsim {

SerialState make_serial_state(const BoneView& bone, const Tool& tool) {
  SerialState state;
  state.tool = &tool;
  state.profile = full_profile_table(tool.profile);
  state.outline = full_outline_table(tool.profile, bone.voxmap.grid.voxel_mm);
  if (tool.teeth) state.lattice = distance_lattice(*tool.teeth);
  take_bone(bone, state);
  return state;
}

void take_bone(const BoneView& bone, SerialState& state) {
  state.grid = bone.voxmap.grid;
  state.bone = dense_remaining_grades(bone);
  state.fill = dense_fill(bone);
}

}  // namespace reamsim
