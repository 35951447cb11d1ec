// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/push_rules.h"

#include "sim/scenario/parse_steps.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// A mistake where the balance of forces cannot be tried with these settings. `section`: what needs it.
void check_balance(const Scenario& s, const KeyLocations& at, const std::string& section) {
  const auto fail = [&](const std::string& key, const std::string& found, const std::string& expected) {
    throw InputError(at.of(key), key, found, "expected " + expected + ", because " + section + " is given");
  };
  if (s.cutting.erosion != ErosionMode::exact) fail("cutting.erosion", "found " + name_of(s.cutting.erosion), "exact");
  if (s.motion.push && s.tool.spin != ToolSpin::envelope)
    fail("tool.spin", "found " + name_of(s.tool.spin), "envelope");
  if (s.output.force_basis) fail("output.force_basis", "found true", "false");
  if (!s.tool.holder.empty()) {
    fail("tool.holder", "found a list of " + std::to_string(s.tool.holder.size()),
         "none: the clearance of a holder needs a prescribed path");
  }
}

}  // namespace

void check_push_step(const Scenario& scenario, const KeyLocations& locations) {
  if (!scenario.motion.push) return;
  const double max_feed_mm_s = scenario.motion.push->max_feed_mm_s, rate_hz = scenario.motion.frame_rate_hz;
  const double most_mm = scenario.engine.max_step_voxels * scenario.bone.voxel_mm;
  if (max_feed_mm_s / rate_hz <= most_mm) return;
  const std::string key = "motion.push.max_feed_mm_s";
  throw InputError(locations.of(key), key, "found " + number_text(max_feed_mm_s),
                   "expected at most " + number_text(most_mm * rate_hz) +
                       ": a frame of it is longer than engine.max_step_voxels; raise frame_rate_hz or lower it");
}

void check_push(const Scenario& scenario, const KeyLocations& locations) {
  if (!scenario.motion.push) return;
  const PushSettings& push = *scenario.motion.push;
  check_balance(scenario, locations, "motion.push");
  const auto fail = [&](const std::string& name, const std::string& found, const std::string& expected) {
    const std::string key = "motion.push." + name;
    throw InputError(locations.of(key), key, found, "expected " + expected);
  };
  if (!push.profile.empty() && locations.given("motion.push.thrust_n"))
    fail("profile", "found beside thrust_n", "one of both");
  // The voxels of a VDB are known when it has been read: sim/scene.
  if (scenario.bone.source != BoneSource::vdb) check_push_step(scenario, locations);
}

void check_compliance(const Scenario& scenario, const KeyLocations& locations) {
  if (!scenario.motion.compliance) return;
  const std::string section = "motion.compliance";
  if (scenario.motion.push) {
    throw InputError(locations.of(section), section, "found beside motion.push",
                     "expected one of both: a push has a balance of forces of its own, with mass and damping");
  }
  check_balance(scenario, locations, section);
  const Vec3& stiffness = scenario.motion.compliance->stiffness_n_mm;
  if (stiffness.minCoeff() < ComplianceSettings::kRigid_n_mm) return;
  throw InputError(locations.of(section + ".stiffness_n_mm"), section + ".stiffness_n_mm",
                   "found 1e6, which is rigid, in all directions",
                   "expected less in one direction at least; remove motion.compliance for a rigid tool");
}

}  // namespace reamsim
