// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "sim/scenario/parse.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// More frames than this are a mistake of unit: at 1 kHz it is nearly three hours.
constexpr double kMaxFrames = 1e7;

void require(const KeyLocations& at, bool fine, const std::string& key, double found, const std::string& expected) {
  if (!fine) at.fail(key, "found " + number_text(found), expected);
}

void check_name(const Scenario& s, const KeyLocations& at) {
  // It names a folder.
  const bool fine = s.name.find('/') == std::string::npos && s.name != "." && s.name != "..";
  if (!fine) at.fail("name", "found " + shown_text(s.name), "a name that a folder can have, without \"/\"");
}

void check_glenoid(const Scenario& s, const KeyLocations& at) {
  const GlenoidSettings& glenoid = s.bone.glenoid;
  if (const auto& marks = glenoid.landmarks) {
    const Vec3 medial = marks->trigonum_spinae_mm - marks->glenoid_center_mm;
    const Vec3 inferior = marks->inferior_angle_mm - marks->glenoid_center_mm;
    if (medial.norm() > 1 && inferior.norm() > 1 && !are_parallel(medial, inferior)) return;
    at.fail("bone.glenoid.landmarks", "found three points on one line or closer than 1 mm",
            "three points that span a plane");
  }
  const bool any = glenoid.center_mm || glenoid.normal || glenoid.superior;
  if (!any || glenoid.near_mm) return;
  const char* const missing = !glenoid.center_mm ? "center_mm" : !glenoid.normal ? "normal" : "superior";
  if (!glenoid.center_mm || !glenoid.normal || !glenoid.superior)
    at.fail(std::string("bone.glenoid.") + missing, "missing", "center_mm, normal and superior together");
  if (are_parallel(*glenoid.normal, *glenoid.superior)) {
    at.fail("bone.glenoid.superior", "found the direction of normal", "a direction across it");
  }
}

void check_side(const Scenario& s, const KeyLocations& at) {
  // A VDB may know its side, which is seen when it is read.
  if (s.bone.side != BodySide::unknown || s.bone.source == BoneSource::vdb) return;
  const char* why = nullptr;
  const bool phantom = s.bone.source == BoneSource::phantom;
  if (phantom && s.bone.phantom.shape == PhantomShape::glenoid) why = "bone.phantom.shape is glenoid";
  if (s.bone.glenoid.is_given()) why = "bone.glenoid is given";
  if (s.motion.frame == PoseFrame::glenoid) why = "motion.frame is glenoid";
  if (s.bone.pilot_hole && s.bone.pilot_hole->frame == PoseFrame::glenoid) why = "bone.pilot_hole.frame is glenoid";
  if (why != nullptr) at.fail("bone.side", "missing", std::string("left or right, because ") + why);
}

void need_glenoid_frame(const Scenario& s, const KeyLocations& at, bool in_it, const std::string& key) {
  // Every phantom has its own, and a VDB may have one.
  const bool has_own = s.bone.source == BoneSource::phantom || s.bone.source == BoneSource::vdb;
  if (!in_it || has_own || s.bone.glenoid.is_given()) return;
  at.fail(key, "frame is glenoid but bone.glenoid is missing", "bone.glenoid, or frame: bone");
}

void check_camera_frames(const Scenario& s, const KeyLocations& at) {
  for (std::size_t i = 0; i < s.render.user_cameras.size(); ++i) {
    need_glenoid_frame(s, at, s.render.user_cameras[i].frame == PoseFrame::glenoid,
                       "render.user_cameras." + std::to_string(i) + ".frame");
  }
}

void check_crop(const Scenario& s, const KeyLocations& at) {
  if (s.bone.source != BoneSource::ct) return;
  const CtSettings& ct = s.bone.ct;
  if (ct.crop_min_mm.has_value() != ct.crop_max_mm.has_value()) {
    const std::string missing = ct.crop_min_mm ? "bone.ct.crop_max_mm" : "bone.ct.crop_min_mm";
    at.fail(missing, "missing", "crop_min_mm and crop_max_mm together");
  }
  if (ct.crop_min_mm && (ct.crop_min_mm->array() >= ct.crop_max_mm->array()).any()) {
    at.fail("bone.ct.crop_max_mm", "found a corner that is not greater than crop_min_mm on every axis",
            "a larger x, y and z");
  }
}

void check_phantom(const Scenario& s, const KeyLocations& at) {
  if (s.bone.source != BoneSource::phantom) return;
  const PhantomSettings& p = s.bone.phantom;
  const auto need = [&](bool fine, const std::string& name, double found, const std::string& expected) {
    require(at, fine, "bone.phantom." + name, found, expected);
  };
  if (p.shape == PhantomShape::cup) {
    const double half_width = std::min(p.size_mm.x(), p.size_mm.y()) / 2;
    need(p.cup_depth_mm <= p.radius_mm, "cup_depth_mm", p.cup_depth_mm, "no more than radius_mm");
    need(p.cup_depth_mm < p.size_mm.z(), "cup_depth_mm", p.cup_depth_mm, "less than the block's height");
    const double opening = std::sqrt(p.cup_depth_mm * (2 * p.radius_mm - p.cup_depth_mm));
    need(opening <= half_width, "radius_mm", p.radius_mm,
         "a cup whose opening (radius " + number_text(opening) + " mm) fits the block");
  } else if (p.shape == PhantomShape::layered) {
    need(p.cortical_mm < p.size_mm.z(), "cortical_mm", p.cortical_mm, "less than the block's height");
  } else if (p.shape == PhantomShape::glenoid) {
    need(p.width_mm < p.height_mm, "width_mm", p.width_mm, "less than height_mm");
    need(2 * p.face_radius_mm >= p.height_mm, "face_radius_mm", p.face_radius_mm, "at least half of height_mm");
    need(2 * p.shell_mm < p.width_mm, "shell_mm", p.shell_mm, "less than half of width_mm");
    need(p.subchondral_mm < p.vault_depth_mm, "subchondral_mm", p.subchondral_mm, "less than vault_depth_mm");
  }
}

void check_holder(const Scenario& s, const KeyLocations& at) {
  for (const PassSpec& pass : passes_of(s)) {
    for (std::size_t i = 0; i < pass.tool.holder.size(); ++i) {
      const HolderPartSettings& part = pass.tool.holder[i];
      require(at, part.to_z_mm > part.from_z_mm, pass.tool_key + ".holder." + std::to_string(i) + ".to_z_mm",
              part.to_z_mm, "more than from_z_mm, " + number_text(part.from_z_mm));
    }
  }
}

/// A limit that nothing is compared with would look like one that is kept.
void check_clearance(const Scenario& s, const KeyLocations& at) {
  const auto has_holder = [](const PassSpec& pass) { return !pass.tool.holder.empty(); };
  if (std::ranges::any_of(passes_of(s), has_holder)) return;
  const std::string expected = "tool.holder as well: it lists the parts whose clearance is measured";
  require(at, s.clearance.least_mm == 0, "clearance.least_mm", s.clearance.least_mm, expected);
  if (s.clearance.envelope) at.fail("clearance.envelope", "found without tool.holder", expected);
}

void check_keyframes(const Scenario& s, const KeyLocations& at) {
  const auto& keys = s.motion.keyframes;
  if (!at.given("motion.keyframes")) return;
  if (keys.size() < 2) {
    at.fail("motion.keyframes", "found a list of " + std::to_string(keys.size()), "two or more keyframes");
  }
  for (std::size_t i = 1; i < keys.size(); ++i) {
    require(at, keys[i].time_s > keys[i - 1].time_s, "motion.keyframes." + std::to_string(i) + ".time_s",
            keys[i].time_s,
            "a time later than that of the previous keyframe, " + number_text(keys[i - 1].time_s) + " s");
  }
}

void check_frame_count(const Scenario& s, const KeyLocations& at) {
  double duration_s = 0;
  std::string key = s.motion.passes.empty() ? "motion.plunge" : "motion.passes";
  for (const PassSpec& pass : passes_of(s)) {
    const auto& p = pass.motion.plunge;
    if (!p) continue;
    duration_s += (p->approach_mm + p->depth_mm) / p->feed_mm_s + p->dwell_s + p->retract_mm / p->retract_mm_s;
  }
  if (s.motion.push) {
    key = "motion.push.time_s";
    duration_s = s.motion.push->time_s;
  }
  if (!s.motion.keyframes.empty()) {
    key = "motion.keyframes";
    duration_s = s.motion.keyframes.back().time_s - s.motion.keyframes.front().time_s;
  }
  if (duration_s * s.motion.frame_rate_hz <= kMaxFrames) return;
  at.fail(key,
          "takes " + number_text(duration_s) + " s, " + number_text(std::ceil(duration_s * s.motion.frame_rate_hz)) +
              " frames at frame_rate_hz",
          "at most " + number_text(kMaxFrames) + " frames");
}

void require_envelope(const Scenario& s, const KeyLocations& at, const std::string& because) {
  for (const PassSpec& pass : passes_of(s)) {
    if (pass.tool.spin == ToolSpin::envelope) continue;
    at.fail(pass.tool_key + ".spin", "found " + name_of(pass.tool.spin), "envelope, because " + because);
  }
}

/// The engine `implicit` knows the tool by its envelope of revolution, and has no shell points.
void check_spin_of_implicit(const Scenario& s, const KeyLocations& at) {
  if (s.engine.type == EngineKind::implicit) require_envelope(s, at, "engine.type is implicit");
}

void check_law_of_implicit(const Scenario& s, const KeyLocations& at) {
  if (s.engine.type != EngineKind::implicit || s.cutting.law == CuttingLaw::energy) return;
  at.fail("cutting.law", "found " + name_of(s.cutting.law), "energy, because engine.type is implicit");
}

void check_exact(const Scenario& s, const KeyLocations& at) {
  const EngineKind engine = engine_of(s);
  const std::string because = ", because engine.type is " + name_of(engine);
  if (s.cutting.erosion != ErosionMode::exact) {
    if (engine == EngineKind::exact)
      at.fail("cutting.erosion", "found " + name_of(s.cutting.erosion), "exact" + because + " (bricked can do it)");
    return;
  }
  if (engine != EngineKind::exact) at.fail("cutting.erosion", "found exact", "remove or wear" + because);
  if (s.cutting.law != CuttingLaw::energy)
    at.fail("cutting.erosion", "found exact", "remove or wear, because cutting.law is " + name_of(s.cutting.law));
}

void check_energy_table(const Scenario& s, const KeyLocations& at) {
  const auto& table = s.cutting.specific_energy_table;
  const std::string table_key = "cutting.specific_energy_table";
  if (at.given(table_key) && table.size() < 2) {
    at.fail(table_key, "found a list of " + std::to_string(table.size()), "two or more points");
  }
  for (std::size_t i = 1; i < table.size(); ++i) {
    require(at, table[i].density_g_cm3 > table[i - 1].density_g_cm3,
            table_key + "." + std::to_string(i) + ".density_g_cm3", table[i].density_g_cm3,
            "more than at the previous point, " + number_text(table[i - 1].density_g_cm3));
  }
}

void check_size_effect(const Scenario& s, const KeyLocations& at) {
  if (const auto& size = s.cutting.size_effect)
    require(at, size->least_mm <= size->most_mm, "cutting.size_effect.least_mm", size->least_mm,
            "no more than most_mm");
}

void check_edge_force(const Scenario& s, const KeyLocations& at) {
  const CuttingSettings& cutting = s.cutting;
  if (cutting.edge_force && cutting.law != CuttingLaw::energy) {
    at.fail("cutting.law", "found " + name_of(cutting.law), "energy, because cutting.edge_force is given");
  }
  if (cutting.edge_force && (cutting.size_effect || cutting.erosion != ErosionMode::exact)) {
    at.fail("cutting.preset", "found " + name_of(cutting.preset) + ", which has an edge force",
            "erosion exact and no size_effect, or another preset");
  }
  // The edge force is that of the envelope of revolution.
  if (cutting.edge_force) require_envelope(s, at, "cutting.edge_force is given");
}

void check_force_basis(const Scenario& s, const KeyLocations& at) {
  if (!s.output.force_basis) return;
  const std::string because = ", because output.force_basis is true";
  if (s.cutting.law != CuttingLaw::energy) {
    at.fail("cutting.law", "found " + name_of(s.cutting.law), "energy" + because);
  } else if (s.cutting.erosion == ErosionMode::wear) {
    at.fail("cutting.erosion", "found wear", "exact or remove" + because);
  } else if (engine_of(s) != EngineKind::exact && engine_of(s) != EngineKind::bricked) {
    at.fail("engine.type", "found " + name_of(s.engine.type), "auto, exact or bricked" + because);
  }
}

/// A rule of these keys, which is not checked where one of them has a mistake already.
struct Rule {
  std::vector<std::string_view> keys;
  void (*check)(const Scenario& s, const KeyLocations& at);
};

const std::vector<Rule> kRules{
    {{"name"}, check_name},
    {{"bone.glenoid"}, check_glenoid},
    {{"bone.glenoid.rim_mm"}, check_rim},
    {{"bone.source", "bone.side", "bone.glenoid", "bone.phantom.shape", "bone.pilot_hole", "motion.frame"}, check_side},
    {{"bone.source", "bone.glenoid", "motion.frame"},
     [](const Scenario& s, const KeyLocations& at) {
       need_glenoid_frame(s, at, s.motion.frame == PoseFrame::glenoid, "motion.frame");
     }},
    {{"bone.source", "bone.glenoid", "bone.pilot_hole"},
     [](const Scenario& s, const KeyLocations& at) {
       const auto& hole = s.bone.pilot_hole;
       need_glenoid_frame(s, at, hole && hole->frame == PoseFrame::glenoid, "bone.pilot_hole.frame");
     }},
    {{"bone.source", "bone.glenoid", "render.user_cameras"}, check_camera_frames},
    {{"bone.ct"}, check_crop},
    {{"bone.phantom"}, check_phantom},
    {{"tool.holder", "motion.passes"}, check_holder},
    {{"tool.holder", "motion.passes", "clearance"}, check_clearance},
    {{"motion"}, check_keyframes},
    {{"motion"}, check_frame_count},
    {{"motion", "cutting", "engine", "tool", "output"}, check_push},
    {{"motion"}, check_csv},
    {{"motion", "cutting", "tool", "output"}, check_compliance},
    {{"engine.type", "tool.spin", "motion.passes"}, check_spin_of_implicit},
    {{"engine.type", "cutting.law"}, check_law_of_implicit},
    {{"metrics.implant"}, check_implant},
    {{"bone.source", "bone.glenoid", "metrics.implant"},
     [](const Scenario& s, const KeyLocations& at) {
       const auto& implant = s.metrics.implant;
       need_glenoid_frame(s, at, implant && implant->frame == ImplantFrame::glenoid, "metrics.implant.frame");
     }},
    {{"cutting.specific_energy_table"}, check_energy_table},
    {{"cutting.size_effect"}, check_size_effect},
    {{"cutting", "tool.spin", "motion.passes"}, check_edge_force},
    {{"cutting", "engine", "output"}, check_force_basis},
    {{"bone.source", "output"},
     [](const Scenario& s, const KeyLocations& at) {
       const bool wrong = s.output.segmentation && s.bone.source == BoneSource::phantom;
       if (wrong) at.fail("output.segmentation", "found true", "false, because a phantom lies over no scan");
     }},
    {{"cutting", "engine.type"}, check_exact},
    {{"render.user_cameras"}, check_cameras},
};

}  // namespace

void check_rules(const Scenario& scenario, const KeyLocations& locations, MistakeList& mistakes) {
  for (const Rule& rule : kRules) {
    const auto wrong = [&](std::string_view key) { return mistakes.concerns(key); };
    if (std::ranges::none_of(rule.keys, wrong)) mistakes.attempt([&] { rule.check(scenario, locations); });
  }
  check_markups_frames(scenario, locations, mistakes);
}

}  // namespace reamsim
