// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "sim/base/geometry.h"
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

namespace {

/// The key that says in which frame the point of a key is, with its value; "" where that is the frame of the bone.
std::string other_frame(const Scenario& s, const std::string& key) {
  const auto unless_bone = [](const std::string& frame_key, const std::string& frame) {
    return frame == name_of(PoseFrame::bone) ? "" : frame_key + " is " + frame;
  };
  const std::string camera = "render.user_cameras.", implant = "metrics.implant.", hole = "bone.pilot_hole.";
  if (key.starts_with("motion.")) return unless_bone("motion.frame", name_of(s.motion.frame));
  if (key.starts_with(implant)) return unless_bone(implant + "frame", name_of(s.metrics.implant->frame));
  if (key.starts_with(hole)) return unless_bone(hole + "frame", name_of(s.bone.pilot_hole->frame));
  if (!key.starts_with(camera)) return "";
  const std::string section = key.substr(0, key.rfind('.'));
  return unless_bone(section + ".frame", name_of(s.render.user_cameras[std::stoul(key.substr(camera.size()))].frame));
}

}  // namespace

void check_markups_frames(const Scenario& scenario, const KeyLocations& locations, MistakeList& mistakes) {
  for (const MarkupsSource& source : scenario.markups) {
    const std::string frame = other_frame(scenario, source.key);
    if (frame.empty()) continue;
    mistakes.add(InputError(locations.of(source.key), source.key,
                            "found a point of markups, which is in the frame of the bone, and " + frame,
                            "expected frame: bone, or 3 numbers"));
  }
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

namespace {

const std::string kImplant = "metrics.implant";

// Below this angle (about half a degree) a direction across another one is noise.
constexpr double kLeastCrossing = 0.01;
// A shorter peg is a point.
constexpr double kLeastPeg_mm = 0.1;

/// Throws InputErrors of one implant.
class ImplantRules {
 public:
  ImplantRules(const ImplantSettings& implant, const KeyLocations& locations) : implant_(implant), at_(locations) {}

  void check_footprint() const {
    const bool sized = implant_.width_mm > 0 || implant_.height_mm > 0;
    if (sized && implant_.diameter_mm > 0) {
      fail("diameter_mm", "found diameter_mm beside width_mm or height_mm", "either the one or the others");
    }
    if (sized && implant_.width_mm == 0) fail("width_mm", "missing", "width_mm and height_mm together");
    if (sized && implant_.height_mm == 0) fail("height_mm", "missing", "width_mm and height_mm together");
    if (implant_.footprint == FootprintShape::pear && implant_.height_mm < implant_.width_mm) {
      fail("height_mm", "found " + number_text(implant_.height_mm), "at least width_mm, because footprint is pear");
    }
    if (implant_.backside_radius_mm == 0) return;
    check_covered("diameter_mm", implant_.diameter_mm);
    check_covered("width_mm", implant_.width_mm);
    check_covered("height_mm", implant_.height_mm);
  }

  void check_pose() const {
    const bool outward = implant_.frame == ImplantFrame::bone || implant_.axis.z() > 0;
    if (!outward) fail("axis", "found an axis with z ≤ 0", "a direction out of the bone, z > 0");
    if (!implant_.superior) return;
    const double sine = implant_.axis.normalized().cross(implant_.superior->normalized()).norm();
    if (sine < kLeastCrossing) fail("superior", "found a direction along axis", "a direction across it");
  }

  void check_augment() const {
    if (implant_.augment && implant_.augment->direction.head<2>().norm() == 0) {
      fail("augment.direction", "found x = y = 0", "a direction across the axis of the implant");
    }
  }

  void check_pegs() const {
    for (std::size_t i = 0; i < implant_.pegs.size(); ++i) {
      const PegSettings& peg = implant_.pegs[i];
      if ((peg.to_mm - peg.from_mm).norm() >= kLeastPeg_mm) continue;
      fail("pegs." + std::to_string(i) + ".to_mm", "found a point closer than 0.1 mm to from_mm", "the other end");
    }
  }

 private:
  [[noreturn]] void fail(const std::string& name, const std::string& found, const std::string& expected) const {
    const std::string key = kImplant + "." + name;
    throw InputError(at_.of(key), key, found, "expected " + expected);
  }

  void check_covered(const std::string& name, double size_mm) const {
    if (size_mm <= 2 * implant_.backside_radius_mm) return;
    fail(name, "found " + number_text(size_mm), "no more than twice backside_radius_mm");
  }

  const ImplantSettings& implant_;
  const KeyLocations& at_;
};

}  // namespace

void check_implant(const ImplantSettings& implant, const KeyLocations& locations) {
  const ImplantRules rules(implant, locations);
  rules.check_footprint();
  rules.check_pose();
  rules.check_augment();
  rules.check_pegs();
}

namespace {

constexpr double kLeastRim_mm = 10;   // a joint face, and not a unit mistaken
constexpr double kMostRim_mm = 100;   // likewise
constexpr double kLeastWidth = 0.05;  // of the length: below, the points lie on a line

/// The points' middle, and their main directions, the least spread first.
struct RimSpread {
  Vec3 middle_mm = Vec3::Zero();
  Mat3 directions;
  Vec3 deviations_mm;
};

RimSpread spread_of(const std::vector<Vec3>& rim_mm) {
  RimSpread out;
  for (const Vec3& p : rim_mm) out.middle_mm += p / static_cast<double>(rim_mm.size());
  Mat3 products = Mat3::Zero();
  for (const Vec3& p : rim_mm) products += (p - out.middle_mm) * (p - out.middle_mm).transpose();
  const SymmetricEigen3 axes = symmetric_eigen(Mat3(products / static_cast<double>(rim_mm.size())));
  out.directions = axes.vectors;
  out.deviations_mm = axes.values.cwiseMax(0).cwiseSqrt();
  return out;
}

/// Number of the first point, from 1, whose angle about the centre does not increase; 0 if all are in order.
std::size_t first_out_of_order(const std::vector<Vec3>& rim_mm, const RimSpread& spread) {
  std::vector<double> steps;
  double turned = 0;
  for (std::size_t i = 0; i < rim_mm.size(); ++i) {
    const Vec3 from = rim_mm[i] - spread.middle_mm;
    const Vec3 to = rim_mm[(i + 1) % rim_mm.size()] - spread.middle_mm;
    const auto angle = [&](const Vec3& p) {
      return std::atan2(p.dot(spread.directions.col(1)), p.dot(spread.directions.col(2)));
    };
    steps.push_back(std::remainder(angle(to) - angle(from), 2 * std::numbers::pi));
    turned += steps.back();
  }
  // Round once, whichever way: then the points that step the other way are the ones out of order.
  const auto forwards = std::count_if(steps.begin(), steps.end(), [](double step) { return step > 0; });
  const double way = 2 * forwards >= static_cast<std::ptrdiff_t>(steps.size()) ? 1 : -1;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (way * steps[i] <= 0) return (i + 1) % rim_mm.size() + 1;
  }
  return std::abs(std::abs(turned) - 2 * std::numbers::pi) < 1e-6 ? 0 : 1;
}

}  // namespace

void check_rim(const std::vector<Vec3>& rim_mm, const KeyLocations& locations) {
  if (rim_mm.empty()) return;
  const std::string key = "bone.glenoid.rim_mm";
  const auto fail = [&](const std::string& found, const std::string& expected) {
    throw InputError(locations.of(key), key, "found " + found, "expected " + expected);
  };
  double length_mm = 0;
  for (const Vec3& a : rim_mm) {
    for (const Vec3& b : rim_mm) length_mm = std::max(length_mm, (a - b).norm());
  }
  if (length_mm < kLeastRim_mm || length_mm > kMostRim_mm) {
    fail("a rim " + number_text(std::round(10 * length_mm) / 10) + " mm long",
         "points in mm around a face of " + number_text(kLeastRim_mm) + " to " + number_text(kMostRim_mm) + " mm");
  }
  const RimSpread spread = spread_of(rim_mm);
  if (spread.deviations_mm[1] < kLeastWidth * spread.deviations_mm[2]) {
    fail("points on one line", "points around the face that span a plane");
  }
  if (const std::size_t point = first_out_of_order(rim_mm, spread); point != 0) {
    fail("point " + std::to_string(point) + " out of order", "the points in order around the face, each once");
  }
}

}  // namespace reamsim
