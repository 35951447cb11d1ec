#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "cli/commands.h"
#include "render/frame_schedule.h"
#include "render/render.h"
#include "sim/base/error.h"
#include "sim/base/mistake_list.h"
#include "sim/base/stopwatch.h"
#include "sim/base/text.h"
#include "sim/plan/memory_plan.h"
#include "sim/plan/time_plan.h"
#include "sim/predict/clearance.h"
#include "sim/predict/contact_forecast.h"
#include "sim/run/simulation.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

namespace {

/// Duration of the timed part of the simulation.
constexpr double kTiming_s = 1;
/// Time of a picture of 1920 × 1080, measured on two cores as docs/formats.md describes.
constexpr double kPicture_s = 0.4;

void note_cost(const ReamingScene& scene, Report& report) {
  const RunCost cost = estimate_cost(scene);
  const VoxelGrid& grid = scene.bone.voxmap->grid;
  report.note(fmt::format("motion: {} frames ({:.3f} s at {:g} Hz), {} substeps", cost.frames,
                          static_cast<double>(cost.frames) * scene.motion.frame_s(), scene.motion.frame_rate_hz,
                          cost.substeps));
  report.note(fmt::format("bone: {} x {} x {} voxels of {:g} mm, {} contain bone ({:.1f} mm3)", grid.dims.x(),
                          grid.dims.y(), grid.dims.z(), grid.voxel_mm, scene.bone.view().count_bone(),
                          scene.bone.view().bone_mm3()));
  if (const PointShell& shell = scene.tool.shell; !shell.codes.empty()) {
    report.note(fmt::format("tool: {} shell points, spacing {:g} mm", shell.codes.size(), shell.cell_mm));
  }
  report.note("engine: " + name_of(engine_of(scene.scenario)));
  const MemoryPlan memory = plan_memory(scene);
  report.note("memory: " + megabytes(memory.device_bytes) + " on the device, up to " + megabytes(memory.process_bytes) +
              " in total, plus rendering");
}

/// Times frames, which reams the bone of the scene. Also collects the mistakes that the engine finds.
void note_time(ReamingScene& scene, double load_s, MistakeList& mistakes, Report& report) {
  const RenderSettings& render = scene.scenario.render;
  const std::vector<std::int64_t> frames = picture_frames(render, std::ssize(scene.motion.poses) - 1);
  const int pictures = render.enabled ? count_pictures({render}, frames) : 0;
  const double pixels = double(render.width_px) * render.height_px * render.supersampling * render.supersampling;
  try {
    const Stopwatch watch;
    std::unique_ptr<Engine> engine;
    if (!mistakes.attempt([&] { engine = load_engine(scene); })) return;
    load_s += watch.seconds();
    TimePlan plan;
    if (!mistakes.attempt([&] { plan = plan_time(scene, *engine, kTiming_s); })) return;
    report.note(fmt::format("time: about {:.2g} s for the simulation ({} frames in {} windows timed on {})",
                            plan.simulate_s, plan.timed_frames, plan.windows, engine->device()));
    report.note(
        fmt::format("time: about {:.2g} s for {} pictures, rendered during and after the simulation; {:.2g} s to load",
                    pictures * kPicture_s * pixels / (1920 * 1080), pictures, load_s));
  } catch (const RunError& error) {
    report.warn(std::string("no time estimate: the engine cannot start: ") + error.what());
  }
}

void warn_of_settings(const ReamingScene& scene, Report& report) {
  const auto& poses = scene.motion.poses;
  if (std::none_of(poses.begin(), poses.end(), [](const ToolPose& p) { return p.spin_rpm != 0; })) {
    report.warn("spindle speed is zero: forces are those of a non-rotating tool");
  }
  try {
    require_film_program(scene.scenario.render);
  } catch (const RunError& error) {
    report.warn(error.what());
  }
}

/// As YAML comments, so that the output is a scenario.
void print_findings(const Report& report, const Console& console) {
  for (const std::string& warning : report.warnings) console.say("# warning: " + warning);
  for (const std::string& listing : report.listings) console.say("# " + listing);
  for (const std::string& note : report.notes) console.say("# " + note);
}

void check_command(const ScenarioOptions& options, const Console& console) {
  const Stopwatch load_watch;
  const Scenario scenario = options.parse();
  Report found;
  MistakeList mistakes;
  ReamingScene scene = load_scene(scenario, found, mistakes);
  const double load_s = load_watch.seconds();
  warn_of_contact(scene, forecast_contact(scene), found);
  const std::optional<HolderClearance> clearance = find_clearance(scene);
  if (clearance) warn_of_clearance(*clearance, scene, found);
  warn_of_settings(scene, found);
  Report report;
  report.warnings = found.warnings;
  note_cost(scene, report);
  note_time(scene, load_s, mistakes, report);
  if (clearance) report.note(sentence_of(*clearance, scene));
  if (scene.bone.segmentation) report.note(sentence_of(*scene.bone.segmentation));
  report.listings = std::move(found.listings);
  report.notes.insert(report.notes.end(), found.notes.begin(), found.notes.end());
  // On a terminal, standard error would repeat them.
  if (isatty(STDOUT_FILENO) == 0 || console.quiet) {
    for (const std::string& warning : report.warnings) console.warn(warning);
  }
  print_findings(report, console);
  mistakes.throw_if_any();
  console.say_lines(to_yaml(scene.scenario));
}

}  // namespace

void add_check_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand(
      "check", "Validate a scenario, estimate time and memory, and print it with all defaults; write nothing");
  auto options = std::make_shared<ScenarioOptions>();
  options->add_to(*command);
  command->callback([options, &console] { check_command(*options, console); });
}

}  // namespace reamsim
