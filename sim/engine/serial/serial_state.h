#pragma once

#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/engine/common/outline_table.h"
#include "sim/engine/common/profile_table.h"
#include "sim/engine/common/teeth_table.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// What the serial engine keeps between detect and cut.
struct SerialState {
  const Tool* tool = nullptr;
  ProfileTable profile;
  OutlineTable outline;
  DistanceLattice lattice{};  ///< of the tool's teeth, where they are resolved
  VoxelGrid grid;
  std::vector<std::uint8_t> bone;   ///< grade, 0 = air or gone
  std::vector<std::uint16_t> fill;  ///< dense
  std::vector<std::int64_t> contacts;
  std::vector<std::pair<std::int64_t, std::int32_t>> removed;  ///< (voxel, frame)
};

SerialState make_serial_state(const BoneView& bone, const Tool& tool);

/// Takes the bone as `voxmap` has it.
void take_bone(const BoneView& bone, SerialState& state);

}  // namespace reamsim
