#include "render/render.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "render/meshes.h"
#include "render/plots.h"
#include "sim/base/error.h"
#include "sim/bone/bone_vdb.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

struct RenderOptions {
  std::string dir;
  std::vector<std::string> cameras;
  std::string context;
  int width_px = 0;
  int height_px = 0;
};

/// The run's own render settings, changed by what the command line says.
RenderSettings settings_of(const RenderOptions& options) {
  std::vector<std::string> overrides;
  const auto set = [&](const std::string& key, const std::string& value) {
    overrides.push_back("render." + key + "=" + value);
  };
  if (options.width_px != 0) set("width_px", std::to_string(options.width_px));
  if (options.height_px != 0) set("height_px", std::to_string(options.height_px));
  if (!options.context.empty()) set("context", options.context);
  if (!options.cameras.empty()) {
    std::string list;
    for (const auto& camera : options.cameras) list += (list.empty() ? "[" : ", ") + camera;
    set("cameras", list + "]");
  }
  return parse_render_settings(options.dir + "/scenario.yaml", overrides);
}

void render_command(const RenderOptions& options, const Console& console) {
  if (!std::filesystem::is_directory(options.dir)) {
    throw InputError({options.dir, 0, 0}, "", "no such results folder", "expected the output folder of a finished run");
  }
  const RenderSettings settings = settings_of(options);
  Progress progress(console, "render", "pictures");
  Report report;
  const double voxel_mm = read_bone_vdb(options.dir + "/reamed.vdb").grid.voxel_mm;
  const double mean_mm = averaged_travel_mm(parse_cutting_settings(options.dir + "/scenario.yaml"), voxel_mm);
  render_pictures(
      options.dir, settings, mean_mm,
      [&](int done, int total, const std::string&) {
        progress.update(done, total);
        if (stop_requested()) throw Interrupted();
      },
      &report);
  progress.finish();
  write_force_plots(options.dir, mean_mm);
  write_removed_density(options.dir);
  const std::string scenario = options.dir + "/scenario.yaml";
  if (parse_tool_spin(scenario) == "resolved") write_torque_spectrum(options.dir);
  write_depth_picture(options.dir, settings.depth_max_mm);
  if (parse_output_settings(scenario).meshes) write_meshes(options.dir, settings.depth_max_mm, report);
  console.tell(report);
  console.say("pictures: " + options.dir + "/frames/, " + options.dir + "/reamed.png");
}

}  // namespace

void add_render_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("render", "Make the pictures of a finished run again, from its results alone");
  auto options = std::make_shared<RenderOptions>();
  command->add_option("DIR", options->dir, "Output folder of a finished run")->required();
  command->add_option("--camera", options->cameras, "glenoid, oblique, section or overview; may be repeated")
      ->expected(1)
      ->take_all();
  command->add_option("--width", options->width_px, "Width in pixels");
  command->add_option("--height", options->height_px, "Height in pixels");
  command->add_option("--context", options->context, "osmesa or egl");
  command->add_flag("--quiet", console.quiet, "Say nothing but warnings and errors");
  command->callback([options, &console] { render_command(*options, console); });
}

}  // namespace reamsim
