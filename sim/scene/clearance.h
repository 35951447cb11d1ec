// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace reamsim {

/// What a part of the holder is near.
enum class Obstacle { bone, envelope };
template <>
inline constexpr auto kChoiceNames<Obstacle> = name_list("bone", "envelope");

/// The smallest distance of the holder from bone and envelope in a frame.
struct FrameClearance {
  std::int64_t frame = 0;
  double mm = 0;                 ///< negative: the part overlaps the surface by as much
  int pass = 1;                  ///< number of the tool's pass
  std::size_t part = 0;          ///< index in the holder of that tool
  Obstacle obstacle{};           ///< what is nearest
  Vec3 point_mm = Vec3::Zero();  ///< its nearest point, B
};

/// The clearance of the parts of a holder, which do not cut, from the bone and a soft-tissue envelope along a motion.
/// The bone of a frame is that at the start of the pass without what the tool's envelope of revolution has swept until
/// then (VoxelCuts); until the tool has cut a voxel for the last time, only its present pose counts. The envelope of
/// soft tissue does not change.
struct HolderClearance {
  std::vector<FrameClearance> frames;  ///< ascending; every frame, or of a long motion some
  FrameClearance least;
  std::optional<std::int64_t> first_below;  ///< the first of `frames` with less than clearance.least_mm, and the last
  std::optional<std::int64_t> last_below;
  Diagnostics envelope;  ///< what is said of its mesh
};

/// nullopt where no pass has a tool.holder. Throws InputError where the mesh of the envelope cannot be read.
std::optional<HolderClearance> find_clearance(const SimulationInput& scene);

/// The name of the part of a clearance, for messages and results.
std::string holder_part_name(const Scenario& scenario, const FrameClearance& clearance);

/// One line for users: the least clearance, its part, frame and place.
std::string sentence_of(const HolderClearance& clearance, const SimulationInput& scene);

/// Warns where the clearance is below clearance.least_mm.
void warn_of_clearance(const HolderClearance& clearance, const SimulationInput& scene, Diagnostics& report);

}  // namespace reamsim
