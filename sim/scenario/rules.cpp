// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <string_view>

#include "sim/scenario/passes.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// More frames than this are a mistake of unit: at 1 kHz it is nearly three hours.
constexpr double kMaxFrames = 1e7;

class Rules {
 public:
  Rules(const Scenario& scenario, const KeyLocations& locations, MistakeList& mistakes)
      : s_(scenario), at_(locations), mistakes_(mistakes) {}

  void check() const {
    rule({"name"}, &Rules::check_name);
    rule({"bone.glenoid"}, &Rules::check_glenoid);
    rule({"bone.glenoid.rim_mm"}, &Rules::check_rim_points);
    rule({"bone.source", "bone.side", "bone.glenoid", "bone.phantom.shape", "bone.pilot_hole", "motion.frame"},
         &Rules::check_side);
    rule({"bone.source", "bone.glenoid", "motion.frame"}, &Rules::check_motion_frame);
    rule({"bone.source", "bone.glenoid", "bone.pilot_hole"}, &Rules::check_pilot_hole_frame);
    rule({"bone.source", "bone.glenoid", "render.user_cameras"}, &Rules::check_camera_frames);
    if (s_.bone.source == BoneSource::ct) rule({"bone.ct"}, &Rules::check_crop);
    if (s_.bone.source == BoneSource::phantom) rule({"bone.phantom"}, &Rules::check_phantom);
    rule({"tool.holder", "motion.passes"}, &Rules::check_holder);
    rule({"tool.holder", "motion.passes", "clearance"}, &Rules::check_clearance);
    rule({"motion"}, &Rules::check_keyframes);
    rule({"motion"}, &Rules::check_frame_count);
    rule({"motion", "cutting", "engine", "tool", "output"}, &Rules::check_push_rules);
    rule({"motion"}, &Rules::check_csv_rules);
    rule({"motion", "cutting", "tool", "output"}, &Rules::check_compliance_rules);
    rule({"engine.type", "tool.spin", "motion.passes"}, &Rules::check_spin_of_implicit);
    rule({"engine.type", "cutting.law"}, &Rules::check_law_of_implicit);
    rule({"metrics.implant"}, &Rules::check_implant);
    rule({"bone.source", "bone.glenoid", "metrics.implant"}, &Rules::check_implant_frame);
    rule({"cutting.specific_energy_table"}, &Rules::check_energy_table);
    rule({"cutting.size_effect"}, &Rules::check_size_effect);
    rule({"cutting", "tool.spin", "motion.passes"}, &Rules::check_edge_force);
    rule({"cutting", "engine", "output"}, &Rules::check_force_basis);
    rule({"cutting", "engine.type"}, &Rules::check_exact);
    rule({"render.user_cameras"}, &Rules::check_user_cameras);
  }

 private:
  /// Checks a rule of these keys, unless one of them has a mistake already.
  void rule(std::initializer_list<std::string_view> keys, void (Rules::*check_rule)() const) const {
    const auto wrong = [this](std::string_view key) { return mistakes_.concerns(key); };
    if (std::ranges::none_of(keys, wrong)) mistakes_.attempt([&] { (this->*check_rule)(); });
  }

  [[noreturn]] void fail(const std::string& key, const std::string& found, const std::string& expected) const {
    throw InputError(at_.of(key), key, found, "expected " + expected);
  }
  void require(bool fine, const std::string& key, double found, const std::string& expected) const {
    if (!fine) fail(key, "found " + number_text(found), expected);
  }

  [[nodiscard]] bool glenoid_given() const {
    return s_.bone.glenoid.landmarks || s_.bone.glenoid.center_mm || s_.bone.glenoid.near_mm;
  }
  [[nodiscard]] bool glenoid_phantom() const {
    return s_.bone.source == BoneSource::phantom && s_.bone.phantom.shape == PhantomShape::glenoid;
  }

  void check_name() const;
  void check_glenoid() const;
  void check_rim_points() const { check_rim(s_.bone.glenoid.rim_mm, at_); }
  void check_side() const;
  void need_glenoid_frame(const std::string& key) const;
  void check_motion_frame() const;
  void check_pilot_hole_frame() const;
  void check_camera_frames() const;
  void check_crop() const;
  void check_phantom() const;
  void check_holder() const;
  void check_clearance() const;
  void check_keyframes() const;
  void check_frame_count() const;
  void check_push_rules() const { check_push(s_, at_); }
  void check_csv_rules() const { check_csv(s_, at_); }
  void check_compliance_rules() const { check_compliance(s_, at_); }
  void require_envelope(const std::string& because) const;
  void check_spin_of_implicit() const;
  void check_law_of_implicit() const;
  void check_exact() const;
  void check_implant() const {
    if (s_.metrics.implant) reamsim::check_implant(*s_.metrics.implant, at_);
  }
  void check_implant_frame() const;
  void check_energy_table() const;
  void check_size_effect() const;
  void check_edge_force() const;
  void check_force_basis() const;
  void check_user_cameras() const { check_cameras(s_.render, at_); }

  const Scenario& s_;
  const KeyLocations& at_;
  MistakeList& mistakes_;
};

void Rules::check_name() const {
  // It names a folder.
  const bool fine = s_.name.find('/') == std::string::npos && s_.name != "." && s_.name != "..";
  if (!fine) fail("name", "found " + shown_text(s_.name), "a name that a folder can have, without \"/\"");
}

/// Sine of the angle between two directions.
double sine_between(const Vec3& a, const Vec3& b) {
  return a.normalized().cross(b.normalized()).norm();
}

// Below this angle (about half a degree) a direction across another one is noise.
constexpr double kLeastSine = 0.01;

void Rules::check_glenoid() const {
  const GlenoidSettings& glenoid = s_.bone.glenoid;
  if (const auto& marks = glenoid.landmarks) {
    const Vec3 medial = marks->trigonum_spinae_mm - marks->glenoid_center_mm;
    const Vec3 inferior = marks->inferior_angle_mm - marks->glenoid_center_mm;
    const bool apart = medial.norm() > 1 && inferior.norm() > 1;
    if (!apart || sine_between(medial, inferior) < kLeastSine) {
      fail("bone.glenoid.landmarks", "found three points on one line or closer than 1 mm",
           "three points that span a plane");
    }
    return;
  }
  const bool any = glenoid.center_mm || glenoid.normal || glenoid.superior;
  if (!any || glenoid.near_mm) return;
  const auto need = [&](bool given, const std::string& name) {
    if (!given) fail("bone.glenoid." + name, "missing", "center_mm, normal and superior together");
  };
  need(glenoid.center_mm.has_value(), "center_mm");
  need(glenoid.normal.has_value(), "normal");
  need(glenoid.superior.has_value(), "superior");
  if (sine_between(*glenoid.normal, *glenoid.superior) < kLeastSine) {
    fail("bone.glenoid.superior", "found the direction of normal", "a direction across it");
  }
}

void Rules::check_side() const {
  // A VDB may know its side, which is seen when it is read.
  if (s_.bone.side != BodySide::unknown || s_.bone.source == BoneSource::vdb) return;
  const char* why = nullptr;
  if (glenoid_phantom()) why = "bone.phantom.shape is glenoid";
  if (glenoid_given()) why = "bone.glenoid is given";
  if (s_.motion.frame == PoseFrame::glenoid) why = "motion.frame is glenoid";
  if (s_.bone.pilot_hole && s_.bone.pilot_hole->frame == PoseFrame::glenoid) why = "bone.pilot_hole.frame is glenoid";
  if (why != nullptr) fail("bone.side", "missing", std::string("left or right, because ") + why);
}

void Rules::need_glenoid_frame(const std::string& key) const {
  // Every phantom has its own, and a VDB may have one.
  if (s_.bone.source == BoneSource::phantom || s_.bone.source == BoneSource::vdb || glenoid_given()) return;
  fail(key, "frame is glenoid but bone.glenoid is missing", "bone.glenoid, or frame: bone");
}

void Rules::check_motion_frame() const {
  if (s_.motion.frame == PoseFrame::glenoid) need_glenoid_frame("motion.frame");
}

void Rules::check_pilot_hole_frame() const {
  if (s_.bone.pilot_hole && s_.bone.pilot_hole->frame == PoseFrame::glenoid)
    need_glenoid_frame("bone.pilot_hole.frame");
}

void Rules::check_camera_frames() const {
  for (std::size_t i = 0; i < s_.render.user_cameras.size(); ++i) {
    if (s_.render.user_cameras[i].frame != PoseFrame::glenoid) continue;
    need_glenoid_frame("render.user_cameras." + std::to_string(i) + ".frame");
  }
}

void Rules::check_implant_frame() const {
  const auto& implant = s_.metrics.implant;
  if (implant && implant->frame == ImplantFrame::glenoid) need_glenoid_frame("metrics.implant.frame");
}

void Rules::check_crop() const {
  const CtSettings& ct = s_.bone.ct;
  if (ct.crop_min_mm.has_value() != ct.crop_max_mm.has_value()) {
    const std::string missing = ct.crop_min_mm ? "bone.ct.crop_max_mm" : "bone.ct.crop_min_mm";
    fail(missing, "missing", "crop_min_mm and crop_max_mm together");
  }
  if (ct.crop_min_mm && (ct.crop_min_mm->array() >= ct.crop_max_mm->array()).any()) {
    fail("bone.ct.crop_max_mm", "found a corner that is not greater than crop_min_mm on every axis",
         "a larger x, y and z");
  }
}

void Rules::check_phantom() const {
  const PhantomSettings& p = s_.bone.phantom;
  const std::string at = "bone.phantom.";
  if (p.shape == PhantomShape::cup) {
    const double half_width = std::min(p.size_mm.x(), p.size_mm.y()) / 2;
    require(p.cup_depth_mm <= p.radius_mm, at + "cup_depth_mm", p.cup_depth_mm, "no more than radius_mm");
    require(p.cup_depth_mm < p.size_mm.z(), at + "cup_depth_mm", p.cup_depth_mm, "less than the block's height");
    const double opening = std::sqrt(p.cup_depth_mm * (2 * p.radius_mm - p.cup_depth_mm));
    require(opening <= half_width, at + "radius_mm", p.radius_mm,
            "a cup whose opening (radius " + number_text(opening) + " mm) fits the block");
  } else if (p.shape == PhantomShape::layered) {
    require(p.cortical_mm < p.size_mm.z(), at + "cortical_mm", p.cortical_mm, "less than the block's height");
  } else if (p.shape == PhantomShape::glenoid) {
    require(p.width_mm < p.height_mm, at + "width_mm", p.width_mm, "less than height_mm");
    require(2 * p.face_radius_mm >= p.height_mm, at + "face_radius_mm", p.face_radius_mm, "at least half of height_mm");
    require(2 * p.shell_mm < p.width_mm, at + "shell_mm", p.shell_mm, "less than half of width_mm");
    require(p.subchondral_mm < p.vault_depth_mm, at + "subchondral_mm", p.subchondral_mm, "less than vault_depth_mm");
  }
}

void Rules::check_holder() const {
  for (const PassSpec& pass : passes_of(s_)) {
    for (std::size_t i = 0; i < pass.tool.holder.size(); ++i) {
      const HolderPartSettings& part = pass.tool.holder[i];
      require(part.to_z_mm > part.from_z_mm, pass.tool_key + ".holder." + std::to_string(i) + ".to_z_mm", part.to_z_mm,
              "more than from_z_mm, " + number_text(part.from_z_mm));
    }
  }
}

/// A limit that nothing is compared with would look like one that is kept.
void Rules::check_clearance() const {
  const auto has_holder = [](const PassSpec& pass) { return !pass.tool.holder.empty(); };
  if (std::ranges::any_of(passes_of(s_), has_holder)) return;
  const std::string expected = "tool.holder as well: it lists the parts whose clearance is measured";
  require(s_.clearance.least_mm == 0, "clearance.least_mm", s_.clearance.least_mm, expected);
  if (s_.clearance.envelope) fail("clearance.envelope", "found without tool.holder", expected);
}

void Rules::check_keyframes() const {
  const auto& keys = s_.motion.keyframes;
  if (!at_.given("motion.keyframes")) return;
  if (keys.size() < 2) {
    fail("motion.keyframes", "found a list of " + std::to_string(keys.size()), "two or more keyframes");
  }
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].time_s > keys[i - 1].time_s) continue;
    fail("motion.keyframes." + std::to_string(i) + ".time_s", "found " + number_text(keys[i].time_s),
         "a time later than that of the previous keyframe, " + number_text(keys[i - 1].time_s) + " s");
  }
}

void Rules::check_frame_count() const {
  double duration_s = 0;
  std::string key = s_.motion.passes.empty() ? "motion.plunge" : "motion.passes";
  for (const PassSpec& pass : passes_of(s_)) {
    const auto& p = pass.motion.plunge;
    if (!p) continue;
    duration_s += (p->approach_mm + p->depth_mm) / p->feed_mm_s + p->dwell_s + p->retract_mm / p->retract_mm_s;
  }
  if (s_.motion.push) {
    key = "motion.push.time_s";
    duration_s = s_.motion.push->time_s;
  }
  if (!s_.motion.keyframes.empty()) {
    key = "motion.keyframes";
    duration_s = s_.motion.keyframes.back().time_s - s_.motion.keyframes.front().time_s;
  }
  if (duration_s * s_.motion.frame_rate_hz <= kMaxFrames) return;
  fail(key,
       "takes " + number_text(duration_s) + " s, " + number_text(std::ceil(duration_s * s_.motion.frame_rate_hz)) +
           " frames at frame_rate_hz",
       "at most " + number_text(kMaxFrames) + " frames");
}

// The engine `implicit` knows the tool by its envelope of revolution, and has no shell points.

void Rules::require_envelope(const std::string& because) const {
  for (const PassSpec& pass : passes_of(s_)) {
    if (pass.tool.spin == ToolSpin::envelope) continue;
    fail(pass.tool_key + ".spin", "found " + name_of(pass.tool.spin), "envelope, because " + because);
  }
}

void Rules::check_spin_of_implicit() const {
  if (s_.engine.type == EngineKind::implicit) require_envelope("engine.type is implicit");
}

void Rules::check_law_of_implicit() const {
  if (s_.engine.type != EngineKind::implicit || s_.cutting.law == CuttingLaw::energy) return;
  fail("cutting.law", "found " + name_of(s_.cutting.law), "energy, because engine.type is implicit");
}

void Rules::check_exact() const {
  const EngineKind engine = engine_of(s_);
  const std::string because = ", because engine.type is " + name_of(engine);
  if (s_.cutting.erosion != ErosionMode::exact) {
    if (engine == EngineKind::exact)
      fail("cutting.erosion", "found " + name_of(s_.cutting.erosion), "exact" + because + " (bricked can do it)");
    return;
  }
  if (engine != EngineKind::exact) fail("cutting.erosion", "found exact", "remove or wear" + because);
  if (s_.cutting.law != CuttingLaw::energy)
    fail("cutting.erosion", "found exact", "remove or wear, because cutting.law is " + name_of(s_.cutting.law));
}

void Rules::check_energy_table() const {
  const auto& table = s_.cutting.specific_energy_table;
  const std::string table_key = "cutting.specific_energy_table";
  if (at_.given(table_key) && table.size() < 2) {
    fail(table_key, "found a list of " + std::to_string(table.size()), "two or more points");
  }
  for (std::size_t i = 1; i < table.size(); ++i) {
    require(table[i].density_g_cm3 > table[i - 1].density_g_cm3, table_key + "." + std::to_string(i) + ".density_g_cm3",
            table[i].density_g_cm3, "more than at the previous point, " + number_text(table[i - 1].density_g_cm3));
  }
}

void Rules::check_size_effect() const {
  const auto& size = s_.cutting.size_effect;
  if (!size) return;
  require(size->least_mm <= size->most_mm, "cutting.size_effect.least_mm", size->least_mm, "no more than most_mm");
}

void Rules::check_edge_force() const {
  const CuttingSettings& cutting = s_.cutting;
  if (cutting.edge_force && cutting.law != CuttingLaw::energy) {
    fail("cutting.law", "found " + name_of(cutting.law), "energy, because cutting.edge_force is given");
  }
  // The edge force is that of the envelope of revolution.
  if (cutting.edge_force) require_envelope("cutting.edge_force is given");
}

void Rules::check_force_basis() const {
  if (!s_.output.force_basis) return;
  const std::string because = ", because output.force_basis is true";
  if (s_.cutting.law != CuttingLaw::energy) {
    fail("cutting.law", "found " + name_of(s_.cutting.law), "energy" + because);
  } else if (s_.cutting.erosion == ErosionMode::wear) {
    fail("cutting.erosion", "found wear", "exact or remove" + because);
  } else if (engine_of(s_) != EngineKind::exact && engine_of(s_) != EngineKind::bricked) {
    fail("engine.type", "found " + name_of(s_.engine.type), "auto, exact or bricked" + because);
  }
}

/// A name that tells files apart on any file system.
bool names_a_file(const std::string& name) {
  const auto fine = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-'; };
  return !name.empty() && name.size() <= 40 && std::ranges::all_of(name, fine);
}

/// Does a camera before this one have its name?
bool is_taken(const std::vector<UserCamera>& cameras, std::size_t index) {
  const auto end = cameras.begin() + static_cast<std::ptrdiff_t>(index);
  return std::any_of(cameras.begin(), end, [&](const UserCamera& c) { return c.name == cameras[index].name; });
}

// A camera closer to its target than this sees nothing of a bone.
constexpr double kLeastView_mm = 0.1;

}  // namespace

void check_rules(const Scenario& scenario, const KeyLocations& locations, MistakeList& mistakes) {
  Rules(scenario, locations, mistakes).check();
  check_markups_frames(scenario, locations, mistakes);
}

void check_cameras(const RenderSettings& render, const KeyLocations& locations) {
  for (std::size_t i = 0; i < render.user_cameras.size(); ++i) {
    const UserCamera& camera = render.user_cameras[i];
    const auto fail = [&](const char* name, const std::string& found, const std::string& expected) {
      const std::string key = "render.user_cameras." + std::to_string(i) + "." + name;
      throw InputError(locations.of(key), key, found, "expected " + expected);
    };
    const std::string expected = "up to 40 lower-case letters, digits, _ and -";
    if (!names_a_file(camera.name)) fail("name", "found " + shown_text(camera.name), expected);
    if (from_name<CameraView>(camera.name)) fail("name", "found a camera name that is used twice", "another name");
    if (is_taken(render.user_cameras, i)) fail("name", "found " + camera.name + " twice", "another name");
    if (!camera.target_mm) continue;  // known only when the bone is
    const Vec3 view = *camera.target_mm - camera.position_mm;
    if (view.norm() < kLeastView_mm) {
      fail("position_mm", "found target_mm", "a place at least " + number_text(kLeastView_mm) + " mm from it");
    }
    if (camera.up && sine_between(view, *camera.up) < kLeastSine) {
      fail("up", "found the direction from position_mm to target_mm", "a direction across it");
    }
  }
}

}  // namespace reamsim
