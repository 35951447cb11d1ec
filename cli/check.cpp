#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "cli/commands.h"
#include "cli/scenario_options.h"
#include "render/render.h"
#include "sim/base/error.h"
#include "sim/run/memory_plan.h"
#include "sim/run/simulation.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

std::string megabytes(std::size_t bytes) {
  return std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

void print_cost(const Console& console, const ReamingScene& scene) {
  const RunCost cost = estimate_cost(scene);
  const VoxelGrid& grid = scene.bone.voxmap.grid;
  char text[512];
  std::snprintf(text, sizeof text,
                "# would run: %lld frames (%.3f s at %g Hz), %lld substeps\n"
                "# bone: %d x %d x %d voxels of %g mm, %lld with bone (%.1f mm3)\n"
                "# tool: %zu shell points, %g mm apart",
                static_cast<long long>(cost.frames), static_cast<double>(cost.frames) * scene.motion.frame_s(),
                scene.motion.frame_rate_hz, static_cast<long long>(cost.substeps), grid.dims.x(), grid.dims.y(),
                grid.dims.z(), grid.voxel_mm, static_cast<long long>(scene.bone.voxmap.count_bone()),
                scene.bone.voxmap.bone_mm3(), scene.tool.shell.codes.size(), scene.tool.shell.cell_mm);
  console.say(text);
  const MemoryPlan memory = plan_memory(scene);
  console.say("# memory: " + megabytes(memory.device_bytes) + " on the device, about " +
              megabytes(memory.process_bytes) +
              " in the program at most, the device's included where that is the processor; pictures come on top");
}

void check_command(const ScenarioOptions& options, const Console& console) {
  const Scenario scenario = parse_scenario(options.file, options.all_overrides());
  Report report;
  const ReamingScene scene = load_scene(scenario, report);
  console.say(to_yaml(scenario));
  print_cost(console, scene);
  const auto& poses = scene.motion.poses;
  if (std::none_of(poses.begin(), poses.end(), [](const ToolPose& p) { return p.spin_rpm != 0; })) {
    report.warn("the tool never spins; its force would be that of a tool pushed through");
  }
  try {
    require_film_program(scenario.render);
  } catch (const RunError& error) {
    report.warn(error.what());
  }
  for (const auto& note : report.notes) console.say("# " + note);
  report.notes.clear();
  console.tell(report);
}

}  // namespace

void add_check_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("check", "Parse, validate and resolve a scenario; print what would run");
  auto options = std::make_shared<ScenarioOptions>();
  options->add_to(*command);
  command->callback([options, &console] { check_command(*options, console); });
}

}  // namespace reamsim
