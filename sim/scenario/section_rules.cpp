// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/geometry.h"
#include "sim/scenario/parse_steps.h"
#include "sim/scenario/show.h"

namespace reamsim {

bool are_parallel(const Vec3& a, const Vec3& b) {
  constexpr double kLeastSine = 0.01;  // below this angle (about half a degree) a direction across another one is noise
  return a.normalized().cross(b.normalized()).norm() < kLeastSine;
}

namespace {

/// Throws where the balance of forces of `section` cannot be tried with these settings.
void check_balance(const Scenario& s, const KeyLocations& at, const std::string& section) {
  const auto fail = [&](const std::string& key, const std::string& found, const std::string& expected) {
    at.fail(key, "found " + found, expected + ", because " + section + " is given");
  };
  if (s.cutting.erosion != ErosionMode::exact) fail("cutting.erosion", name_of(s.cutting.erosion), "exact");
  if (s.motion.push && s.tool.spin != ToolSpin::envelope) fail("tool.spin", name_of(s.tool.spin), "envelope");
  if (s.output.force_basis) fail("output.force_basis", "true", "false");
  if (!s.tool.holder.empty()) {
    fail("tool.holder", "a list of " + std::to_string(s.tool.holder.size()),
         "none: the clearance of a holder needs a prescribed path");
  }
}

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

// How far R·Rᵀ may be from the identity: matrices are written with few digits. A row of length 1.001 is within it.
constexpr double kRotationTolerance = 2.1e-3;

void check_transform(const std::string& key, const TransformSettings& transform, const KeyLocations& locations) {
  if (transform.rotation.empty()) return;
  const auto fail = [&](const std::string& found) {
    locations.fail(key + ".rotation", found, "the three rows of a rotation matrix");
  };
  if (transform.rotation.size() != 3) fail("found " + std::to_string(transform.rotation.size()) + " rows");
  const Mat3 matrix = transform.rotation_matrix();
  const double error = (matrix * matrix.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff();
  if (error > kRotationTolerance) fail("found rows that are not perpendicular or not of length 1");
  if (matrix.determinant() < 0) fail("found a reflection: its determinant is -1");
}

constexpr double kLeastRim_mm = 10;   // a joint face, and not a unit mistaken
constexpr double kMostRim_mm = 100;   // likewise
constexpr double kLeastWidth = 0.05;  // of the length: below, the points lie on a line

/// Number of the first point, from 1, whose angle about the centre does not increase; 0 if all are in order.
std::size_t first_out_of_order(const std::vector<Vec3>& rim_mm, const PointSpread& spread) {
  std::vector<double> steps;
  double turned = 0;
  for (std::size_t i = 0; i < rim_mm.size(); ++i) {
    const double from = angle_in_plane(rim_mm[i], spread), to = angle_in_plane(rim_mm[(i + 1) % rim_mm.size()], spread);
    steps.push_back(std::remainder(to - from, 2 * std::numbers::pi));
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

void check_push_step(const Scenario& s, const KeyLocations& at) {
  if (!s.motion.push) return;
  const double max_feed_mm_s = s.motion.push->max_feed_mm_s, rate_hz = s.motion.frame_rate_hz;
  const double most_mm = s.engine.max_step_voxels * s.bone.voxel_mm;
  if (max_feed_mm_s / rate_hz <= most_mm) return;
  at.fail("motion.push.max_feed_mm_s", "found " + number_text(max_feed_mm_s),
          "at most " + number_text(most_mm * rate_hz) +
              ": a frame of it is longer than engine.max_step_voxels; raise frame_rate_hz or lower it");
}

void check_push(const Scenario& s, const KeyLocations& at) {
  if (!s.motion.push) return;
  check_balance(s, at, "motion.push");
  if (!s.motion.push->profile.empty() && at.given("motion.push.thrust_n"))
    at.fail("motion.push.profile", "found beside thrust_n", "one of both");
  // The voxels of a VDB are known when it has been read: sim/scene.
  if (s.bone.source != BoneSource::vdb) check_push_step(s, at);
}

void check_compliance(const Scenario& s, const KeyLocations& at) {
  if (!s.motion.compliance) return;
  const std::string section = "motion.compliance";
  if (s.motion.push) {
    at.fail(section, "found beside motion.push",
            "one of both: a push has a balance of forces of its own, with mass and damping");
  }
  check_balance(s, at, section);
  if (s.motion.compliance->stiffness_n_mm.minCoeff() < ComplianceSettings::kRigid_n_mm) return;
  at.fail(section + ".stiffness_n_mm", "found 1e6, which is rigid, in all directions",
          "less in one direction at least; remove motion.compliance for a rigid tool");
}

void check_markups_frames(const Scenario& s, const KeyLocations& at, MistakeList& mistakes) {
  for (const MarkupsSource& source : s.markups) {
    const std::string frame = other_frame(s, source.key);
    if (frame.empty()) continue;
    mistakes.attempt([&] {
      at.fail(source.key, "found a point of markups, which is in the frame of the bone, and " + frame,
              "frame: bone, or 3 numbers");
    });
  }
}

void check_implant(const Scenario& s, const KeyLocations& at) {
  if (!s.metrics.implant) return;
  const ImplantSettings& implant = *s.metrics.implant;
  const auto fail = [&](const std::string& name, const std::string& found, const std::string& expected) {
    at.fail("metrics.implant." + name, found, expected);
  };
  const bool sized = implant.width_mm > 0 || implant.height_mm > 0;
  if (sized && implant.diameter_mm > 0)
    fail("diameter_mm", "found diameter_mm beside width_mm or height_mm", "either the one or the others");
  if (sized && implant.width_mm == 0) fail("width_mm", "missing", "width_mm and height_mm together");
  if (sized && implant.height_mm == 0) fail("height_mm", "missing", "width_mm and height_mm together");
  if (implant.footprint == FootprintShape::pear && implant.height_mm < implant.width_mm)
    fail("height_mm", "found " + number_text(implant.height_mm), "at least width_mm, because footprint is pear");
  const auto require_covered = [&](const std::string& name, double size_mm) {
    if (implant.backside_radius_mm > 0 && size_mm > 2 * implant.backside_radius_mm)
      fail(name, "found " + number_text(size_mm), "no more than twice backside_radius_mm");
  };
  require_covered("diameter_mm", implant.diameter_mm);
  require_covered("width_mm", implant.width_mm);
  require_covered("height_mm", implant.height_mm);
  if (implant.frame != ImplantFrame::bone && implant.axis.z() <= 0)
    fail("axis", "found an axis with z ≤ 0", "a direction out of the bone, z > 0");
  if (implant.superior && are_parallel(implant.axis, *implant.superior))
    fail("superior", "found a direction along axis", "a direction across it");
  if (implant.augment && implant.augment->direction.head<2>().norm() == 0)
    fail("augment.direction", "found x = y = 0", "a direction across the axis of the implant");
  constexpr double kLeastPeg_mm = 0.1;  // a shorter one is a point
  for (std::size_t i = 0; i < implant.pegs.size(); ++i) {
    if ((implant.pegs[i].to_mm - implant.pegs[i].from_mm).norm() >= kLeastPeg_mm) continue;
    fail("pegs." + std::to_string(i) + ".to_mm", "found a point closer than 0.1 mm to from_mm", "the other end");
  }
}

void check_csv(const Scenario& scenario, const KeyLocations& locations) {
  if (!scenario.motion.csv) return;
  const CsvMotionSettings& csv = *scenario.motion.csv;
  const std::string section = "motion.csv.";
  const auto fail = [&](const std::string& name, const std::string& found, const std::string& expected) {
    locations.fail(section + name, found, expected);
  };
  const auto require_columns = [&](const std::string& name, const std::vector<std::string>& columns,
                                   std::size_t count) {
    if (columns.size() != count) {
      fail(name, "found a list of " + std::to_string(columns.size()), std::to_string(count) + " names or numbers");
    }
    for (const std::string& column : columns) {
      if (column == "0") fail(name, "found column 0", "numbers from 1");
    }
  };
  require_columns("time_column", {csv.time_column}, 1);
  require_columns("position_columns", csv.position_columns, 3);
  require_columns("quaternion_columns", csv.quaternion_columns, 4);
  require_columns("spin_column", {csv.spin_column}, 1);
  if (csv.separator == Separator::comma && csv.decimal == DecimalMark::comma)
    fail("decimal", "found comma, which separates the columns", "another separator, or decimal: point");
  if (csv.bone_from_tracker) check_transform(section + "bone_from_tracker", *csv.bone_from_tracker, locations);
  if (csv.marker_from_tool) check_transform(section + "marker_from_tool", *csv.marker_from_tool, locations);
  if (csv.bone_from_tracker && scenario.motion.frame != PoseFrame::bone)
    fail("bone_from_tracker", "found beside motion.frame: glenoid", "motion.frame: bone, the frame that it leads to");
}

void check_cameras(const Scenario& s, const KeyLocations& at) {
  const std::vector<UserCamera>& cameras = s.render.user_cameras;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const UserCamera& camera = cameras[i];
    const auto fail = [&](const char* name, const std::string& found, const std::string& expected) {
      at.fail("render.user_cameras." + std::to_string(i) + "." + name, "found " + found, expected);
    };
    const bool names_a_file =
        !camera.name.empty() && camera.name.size() <= 40 && std::ranges::all_of(camera.name, [](char c) {
          return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
        });
    if (!names_a_file) fail("name", shown_text(camera.name), "up to 40 lower-case letters, digits, _ and -");
    if (from_name<CameraView>(camera.name)) fail("name", "a camera name that is used twice", "another name");
    const auto first = std::ranges::find(cameras, camera.name, &UserCamera::name);
    if (&*first != &camera) fail("name", camera.name + " twice", "another name");
    if (!camera.target_mm) continue;  // known only when the bone is
    const Vec3 view = *camera.target_mm - camera.position_mm;
    constexpr double kLeastView_mm = 0.1;  // a camera closer to its target sees nothing of a bone
    if (view.norm() < kLeastView_mm)
      fail("position_mm", "target_mm", "a place at least " + number_text(kLeastView_mm) + " mm from it");
    if (camera.up && are_parallel(view, *camera.up))
      fail("up", "the direction from position_mm to target_mm", "a direction across it");
  }
}

void check_rim(const Scenario& s, const KeyLocations& at) {
  const std::vector<Vec3>& rim_mm = s.bone.glenoid.rim_mm;
  if (rim_mm.empty()) return;
  const auto fail = [&](const std::string& found, const std::string& expected) {
    at.fail("bone.glenoid.rim_mm", "found " + found, expected);
  };
  double length_mm = 0;
  for (const Vec3& a : rim_mm) {
    for (const Vec3& b : rim_mm) length_mm = std::max(length_mm, (a - b).norm());
  }
  if (length_mm < kLeastRim_mm || length_mm > kMostRim_mm) {
    fail("a rim " + number_text(std::round(10 * length_mm) / 10) + " mm long",
         "points in mm around a face of " + number_text(kLeastRim_mm) + " to " + number_text(kMostRim_mm) + " mm");
  }
  const PointSpread spread = spread_of_points(rim_mm);
  const Vec3 deviations_mm = spread.axes.values.cwiseMax(0).cwiseSqrt();
  if (deviations_mm[1] < kLeastWidth * deviations_mm[2])
    fail("points on one line", "points around the face that span a plane");
  if (const std::size_t point = first_out_of_order(rim_mm, spread); point != 0)
    fail("point " + std::to_string(point) + " out of order", "the points in order around the face, each once");
}

}  // namespace reamsim
