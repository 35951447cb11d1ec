#include "sim/scene/scene.h"

#include "sim/base/error.h"
#include "sim/bone/frame_check.h"
#include "sim/bone/voxmap/lattice.h"
#include "sim/tool/clipped_tool.h"

namespace reamsim {

namespace {

/// Engines that clip voxels or test them against the surface need no shell points.
ShellUse shell_use(const Scenario& scenario) {
  const bool by_surface = engine_of(scenario) == EngineKind::exact || engine_of(scenario) == EngineKind::implicit;
  return by_surface ? ShellUse::none : ShellUse::touches_voxels;
}

void load_tool_of(ReamingScene& scene, double voxel_mm, Report& report) {
  const Scenario& scenario = scene.scenario;
  scene.tool = load_tool(scenario.tool, voxel_mm, shell_use(scenario), report);
  if (scenario.cutting.erosion != ErosionMode::exact) return;
  constexpr double kGridMemoryFraction = 0.25;  // bone, engine and results need the rest
  prepare_clipping(scene.tool, scenario.tool, voxel_mm, kGridMemoryFraction * machine_memory_bytes(), report);
}

/// Checks that need the anatomy of a VDB, which is known only after reading it.
void check_camera_frames(const ReamingScene& scene) {
  const auto& cameras = scene.scenario.render.user_cameras;
  for (std::size_t i = 0; i < cameras.size() && !scene.bone.glenoid; ++i) {
    if (cameras[i].frame != PoseFrame::glenoid) continue;
    throw InputError({}, "render.user_cameras." + std::to_string(i) + ".frame",
                     "frame is glenoid but bone.glenoid is missing", "add it, or use frame: bone");
  }
}

/// The motion, with the depth of a plunge counted from entry_mm.
MotionSettings counted_motion(ReamingScene& scene, Report& report) {
  MotionSettings motion = scene.scenario.motion;
  if (!motion.plunge || motion.plunge->from != PlungeStart::contact) return motion;
  scene.first_contact = find_first_contact(scene.bone, scene.tool, *motion.plunge, motion.frame);
  motion.plunge = counted_from(*scene.first_contact, *motion.plunge);
  report.note(sentence_of(*scene.first_contact));
  return motion;
}

}  // namespace

ReamingScene load_scene(const Scenario& scenario, Report& report, MistakeList& frame_mistakes) {
  ReamingScene scene;
  scene.scenario = scenario;
  for (const std::string& note : scenario.notes) report.warn(note);
  MistakeList mistakes;
  // All parts are loaded even if one fails, to report all mistakes at once.
  const bool bone = mistakes.attempt([&] {
    scene.bone = load_bone(with_surface_voxels(scenario.bone, scenario.cutting), report);
    scene.scenario.bone.side = scene.bone.side;
  });
  const double voxel_mm = bone ? scene.bone.voxmap->grid.voxel_mm : scenario.bone.voxel_mm;
  const bool tool = mistakes.attempt([&] { load_tool_of(scene, voxel_mm, report); });
  const bool from_contact = scenario.motion.plunge && scenario.motion.plunge->from == PlungeStart::contact;
  if (from_contact ? bone && tool : bone || scenario.motion.frame != PoseFrame::glenoid) {
    mistakes.attempt([&] { scene.motion = build_motion(counted_motion(scene, report), scene.bone.glenoid, report); });
  }
  if (bone) mistakes.attempt([&] { check_camera_frames(scene); });
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

ReamingScene load_scene(const Scenario& scenario, Report& report) {
  MistakeList mistakes;
  ReamingScene scene = load_scene(scenario, report, mistakes);
  mistakes.throw_if_any();
  return scene;
}

}  // namespace reamsim
