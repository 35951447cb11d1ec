#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace reamsim {

/// Prediction of contact from the tool's envelope of revolution, without simulation.
struct ContactForecast {
  double start_mm3 = 0;         ///< bone in the tool at its first pose
  bool touches = false;         ///< the tool touches the bone
  double nearest_mm = 0;        ///< smallest distance if it does not, to within a voxel (more on very long paths)
  std::int64_t frame = 0;       ///< the frame of that distance
  Vec3 bone_mm = Vec3::Zero();  ///< the nearest point of the bone, B
};

/// Of the present pass.
ContactForecast forecast_contact(const ReamingScene& scene);
/// Of the present pass and the later ones, with the bone that the passes before are predicted to leave.
std::vector<ContactForecast> forecast_passes(const ReamingScene& scene);

/// Warns of a tool that starts in the bone or never touches it. `pass` begins the messages.
void warn_of_contact(const ReamingScene& scene, const ContactForecast& forecast, Report& report,
                     const std::string& pass = "");
void warn_of_contact(const ReamingScene& scene, const std::vector<ContactForecast>& forecasts, Report& report);

}  // namespace reamsim
