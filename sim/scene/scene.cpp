// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/scene.h"

#include <utility>

#include "sim/anatomy/find_glenoid.h"
#include "sim/anatomy/run_metrics.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/parse_steps.h"
#include "sim/scene/swept_bone.h"
#include "sim/tool/tool_path.h"

namespace reamsim {

namespace {

Tool load_tool_for(const Scenario& scenario, const ToolSettings& settings, double voxel_mm, Diagnostics& report) {
  // Engines that clip voxels or test them against the surface need no shell points.
  const bool by_surface = engine_of(scenario) == EngineKind::exact || engine_of(scenario) == EngineKind::implicit;
  Tool tool = load_tool(settings, voxel_mm, by_surface ? ShellUse::none : ShellUse::touches_voxels, report);
  if (scenario.cutting.erosion != ErosionMode::exact) return tool;
  constexpr double kGridMemoryFraction = 0.25;  // bone, engine and results need the rest
  prepare_clipping(tool, settings, voxel_mm, kGridMemoryFraction * machine_memory_bytes(), report);
  return tool;
}

bool starts_at_contact(const auto& way) {
  return way && way->from == PlungeStart::contact;
}

/// The motion of a pass, with the depth of its plunge or push counted from entry_mm.
MotionSettings counted_motion(SimulationInput& scene, const PassSpec& spec, const Tool& tool, Diagnostics& report) {
  std::optional<FirstContact>& contact = scene.first_contacts.emplace_back();
  MotionSettings motion = spec.motion;
  const auto count = [&](auto& way, const std::string& section) {
    if (contact || !starts_at_contact(way)) return;
    contact = find_first_contact(scene.bone, tool, way->entry_mm, way->axis, motion.frame, section);
    count_from(*contact, *way);
    report.note(sentence_of(*contact));
  };
  count(motion.push, "motion.push");
  count(motion.plunge, "motion.plunge");
  return motion;
}

/// Loads a pass of a scenario. `bone`: it has been loaded; without it, no motion that needs it can be.
Pass load_pass(SimulationInput& scene, const PassSpec& spec, bool bone, MistakeList& mistakes, Diagnostics& report) {
  const double voxel_mm = bone ? scene.bone.voxmap->grid.voxel_mm : scene.scenario.bone.voxel_mm;
  Pass pass;
  const auto attempt = [&](const auto& work) {
    return mistakes.attempt([&] {
      try {
        work();
      } catch (const InputError& error) {
        throw in_pass(spec, error);
      }
    });
  };
  const bool tool = attempt([&] { pass.tool = load_tool_for(scene.scenario, spec.tool, voxel_mm, report); });
  const bool from_contact = starts_at_contact(spec.motion.plunge) || starts_at_contact(spec.motion.push);
  if (from_contact ? bone && tool : bone || spec.motion.frame != PoseFrame::glenoid) {
    attempt([&] {
      pass.motion = build_motion(counted_motion(scene, spec, pass.tool, report), scene.bone.glenoid, report);
    });
  }
  return pass;
}

/// Loads all passes; their frames follow one another.
void load_passes(SimulationInput& scene, bool bone, MistakeList& mistakes, Diagnostics& report) {
  std::vector<Pass> passes;
  for (const PassSpec& spec : passes_of(scene.scenario)) {
    Pass& pass = passes.emplace_back(load_pass(scene, spec, bone, mistakes, report));
    if (passes.size() == 1) continue;
    const Motion& before = passes[passes.size() - 2].motion;
    pass.motion.first_frame = before.last_frame() + 1;
    pass.motion.pass = before.pass + 1;
  }
  scene.later_passes = std::move(passes);
  begin_next_pass(scene);
}

/// Checks that need the anatomy of a VDB, which is known only after reading it.
void check_camera_frames(const SimulationInput& scene) {
  const auto& cameras = scene.scenario.render.user_cameras;
  for (std::size_t i = 0; i < cameras.size() && !scene.bone.glenoid; ++i) {
    if (cameras[i].frame != PoseFrame::glenoid) continue;
    throw InputError({}, "render.user_cameras." + std::to_string(i) + ".frame",
                     "frame is glenoid but bone.glenoid is missing", "add it, or use frame: bone");
  }
}

/// Motion of the tool between two poses of a long motion, voxels.
constexpr double kPassStep_voxels = 0.5;

FillBricks predicted_after(const SimulationInput& scene, const FillBricks& fill, const Tool& tool,
                           const Motion& motion) {
  if (motion.poses.empty()) return fill;
  BoundedPath path(tool.reach_mm, kPassStep_voxels * scene.bone.voxmap->grid.voxel_mm);
  path.add(motion.poses);
  std::vector<ToolPose> poses;
  for (const PathSample& sample : path.finish()) poses.push_back(sample.pose);
  const bool whole_voxels = scene.scenario.cutting.erosion != ErosionMode::exact;
  return predict_swept_bone(*scene.bone.voxmap, fill, tool.profile, poses, whole_voxels).fill;
}

}  // namespace

bool begin_next_pass(SimulationInput& scene) {
  if (scene.later_passes.empty()) return false;
  scene.tool = std::move(scene.later_passes.front().tool);
  scene.motion = std::move(scene.later_passes.front().motion);
  scene.later_passes.erase(scene.later_passes.begin());
  return true;
}

SimulationInput load_scene(const Scenario& scenario, Diagnostics& report, MistakeList& frame_mistakes,
                           BoneCache* bones) {
  SimulationInput scene;
  scene.scenario = scenario;
  for (const std::string& note : scenario.notes) report.warn(note);
  for (const MarkupsSource& source : scenario.markups) report.note(source.key + ": " + source.found);
  MistakeList mistakes;
  // All parts are loaded even if one fails, to report all mistakes at once.
  const bool bone = mistakes.attempt([&] {
    const BoneSettings settings = with_surface_voxels(scenario.bone, scenario.cutting);
    scene.bone = bones == nullptr ? load_bone(settings, report) : bones->load(settings, report);
    scene.scenario.bone.side = scene.bone.side;
    if (scenario.bone.source == BoneSource::vdb) scene.scenario.bone.voxel_mm = scene.bone.voxmap->grid.voxel_mm;
  });
  load_passes(scene, bone, mistakes, report);
  mistakes.attempt([&] {
    const auto& implant = scenario.metrics.implant;
    if (implant && implant->mesh) scene.implant_mesh = read_implant_mesh(*implant, report);
  });
  if (bone) mistakes.attempt([&] { check_camera_frames(scene); });
  if (bone) mistakes.attempt([&] { check_push_step(scene.scenario, scenario.keys); });
  MistakeList frame;
  if (bone) check_glenoid_frame(scene.bone, scenario.bone, frame, report);
  const auto located = [&](const MistakeList& found, MistakeList& to) {
    try {
      found.throw_if_any();
    } catch (const InputError& error) {
      to.add(scenario.keys.located(error));
    }
  };
  MistakeList all;
  located(mistakes, all);
  located(frame, all.empty() ? frame_mistakes : all);
  all.throw_if_any();
  return scene;
}

SimulationInput load_scene(const Scenario& scenario, Diagnostics& report, BoneCache* bones) {
  MistakeList mistakes;
  SimulationInput scene = load_scene(scenario, report, mistakes, bones);
  mistakes.throw_if_any();
  return scene;
}

void for_each_predicted_pass(const SimulationInput& scene, const VisitPass& visit) {
  visit(scene.bone.fill, scene.tool, scene.motion);
  if (scene.later_passes.empty()) return;
  FillBricks fill = predicted_after(scene, scene.bone.fill, scene.tool, scene.motion);
  for (const Pass& pass : scene.later_passes) {
    visit(fill, pass.tool, pass.motion);
    fill = predicted_after(scene, fill, pass.tool, pass.motion);
  }
}

}  // namespace reamsim
