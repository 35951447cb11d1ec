// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/tool/tool_path.h"

namespace reamsim {

/// Prediction of contact from the tool's envelope of revolution, without simulation.
struct ContactForecast {
  double start_mm3 = 0;         ///< bone in the tool at its first pose
  bool touches = false;         ///< the tool touches the bone, or comes so close that a run may find contact
  double nearest_mm = 0;        ///< smallest distance if it does not, to within a voxel (more on very long paths)
  std::int64_t frame = 0;       ///< the frame of that distance
  Vec3 bone_mm = Vec3::Zero();  ///< the nearest point of the bone, B
  /// From the first contact to the last removal of bone, which is known to within a brick; none without contact.
  std::optional<FrameSpan> frames;
};

/// For the present pass and the later ones, with the bone that the passes before are predicted to leave.
std::vector<ContactForecast> forecast_passes(const SimulationInput& scene);

/// A run with these passes: at its start, its first and last contact, and its nearest pose.
ContactForecast of_whole_run(const std::vector<ContactForecast>& passes);
/// In which frames these passes touch the bone.
FrameSpans contact_frames(const std::vector<ContactForecast>& passes);
/// ContactForecast::frames alone. `tool`: an envelope about z of T that moves along `path` (B); `fill` at its start.
std::optional<FrameSpan> forecast_contact_frames(const Voxmap& voxmap, const FillBricks& fill, const Profile& tool,
                                                 const ToolPath& path);

/// Warns of a tool that starts in the bone or never touches it, pass by pass.
void warn_of_contact(const SimulationInput& scene, const std::vector<ContactForecast>& forecasts, Diagnostics& report);

}  // namespace reamsim
