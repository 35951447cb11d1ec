#pragma once

#include <cstdint>

#include "sim/scene/scene.h"

namespace reamsim {

/// What the motion will do to the bone, found without simulating: by the tool's envelope of revolution.
struct ContactForecast {
  double start_mm3 = 0;         ///< bone in the tool at its first pose
  bool meets = false;           ///< the tool comes to the bone at all
  double nearest_mm = 0;        ///< where it does not: how close it comes, to within a voxel
  std::int64_t frame = 0;       ///< the frame in which it is closest
  Vec3 bone_mm = Vec3::Zero();  ///< the point of the bone, B
};

ContactForecast forecast_contact(const ReamingScene& scene);

/// Warns of a tool that starts in the bone, or never meets it.
void warn_of_contact(const ReamingScene& scene, const ContactForecast& forecast, Report& report);

}  // namespace reamsim
