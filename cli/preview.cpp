// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/viewer/page.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <optional>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/first_scenario.h"
#include "sim/base/file.h"
#include "sim/record/output_folder.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/paths.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

constexpr double kVoxel_mm = 0.4;  // of a first scenario

struct PreviewOptions {
  std::string input;
  std::string output;
  std::string tool;
  std::optional<double> scale;
  std::vector<std::string> overrides;
  bool overwrite = false;
};

/// A path as a page holds it, which may lie anywhere.
std::string recorded_absolute_path(const std::string& path) {
  return recorded_path(fs::absolute(path).lexically_normal().string());
}

/// A first scenario for the bone in `options.input`, with a plunge into a glenoid that is still to be placed.
PreviewRequest starting_request(const PreviewOptions& options, const std::string& tool, const Console& console) {
  const MeshScale scale = mesh_scale(options.input, scale_of(options.scale, options.overrides), console);
  const FirstScenario first{.first_line = "# A first scenario, put together by reamsim preview.",
                            .bone = first_bone(options.input, kVoxel_mm, scale.scale, CtSettings().threshold_hu,
                                               bone_keys(options.overrides)),
                            .bone_path = recorded_absolute_path(options.input),
                            .tool_path = recorded_absolute_path(tool),
                            .scale_note = scale.why,
                            .glenoid = std::nullopt,
                            .plunge = first_plunge()};
  PreviewRequest out;
  out.scenario.bone = first.bone;
  out.scenario.tool.mesh = tool;
  out.scenario.motion.frame = PoseFrame::glenoid;
  out.scenario.motion.plunge = first.plunge;
  out.text = with_keys(text_of(first), options.overrides);
  const fs::path name = fs::path(options.input).lexically_normal();
  out.source = (name.has_filename() ? name : name.parent_path()).filename().string();
  out.file_name = fs::path(out.source).stem().string() + ".yaml";
  return out;
}

/// The scenario. A glenoid frame or a side that is still missing is no mistake, because the page is there to place it.
Scenario parse_for_preview(const std::string& file, std::vector<std::string> overrides) {
  try {
    return parse_scenario(file, overrides);
  } catch (const InputError& error) {
    const auto names = [&](const char* key) { return std::ranges::count(error.mistakes(), key, &Mistake::key); };
    if (names("bone.side") + names("motion.frame") < std::ssize(error.mistakes())) throw;
    if (names("bone.side")) overrides.emplace_back("bone.side=left");
    if (names("motion.frame")) overrides.emplace_back("motion.frame=bone");
    Scenario scenario = parse_scenario(file, overrides);
    if (names("bone.side")) scenario.bone.side = BodySide::unknown;
    if (names("motion.frame")) scenario.motion.frame = PoseFrame::glenoid;
    return scenario;
  }
}

PreviewRequest request_of(const PreviewOptions& options, const Console& console) {
  if (!is_scenario_name(options.input)) return starting_request(options, reamer_or_own(options.tool), console);
  if (!options.tool.empty()) throw InputError({}, "--tool", "the scenario names the reamer", "change tool.mesh there");
  if (options.scale) throw InputError({}, "--scale", "the scenario has a scale", "change bone.mesh.scale there");
  const Scenario scenario = parse_for_preview(options.input, options.overrides);
  // With --set the page holds the resolved scenario, because keys may stand in any form in a file.
  return {.scenario = scenario,
          .text = options.overrides.empty() ? read_file(options.input, "a scenario") : to_yaml(scenario),
          .file_name = fs::path(options.input).filename().string(),
          .source = scenario.name};
}

std::string page_of(const PreviewRequest& request, Diagnostics& report) {
  try {
    return preview_page(request, report);
  } catch (const InputError& error) {
    throw request.scenario.keys.located(error);
  }
}

void preview_command(const PreviewOptions& options, const Console& console) {
  const std::string kind = lower_extension(options.output);
  if (kind != ".html" && kind != ".htm")
    refuse_file(options.output, "output file does not end in .html", "use -o NAME.html");
  require_replaceable_file(options.output, "-o", options.overwrite, is_preview_page, {options.input});
  const PreviewRequest request = request_of(options, console);
  const auto forced = removing_unfinished(options.output);
  Diagnostics report;
  const auto warnings_of_error = print_on_error(report, console);
  const std::string page = page_of(request, report);
  console.print(report);
  replace_file(options.output, page);
  console.say(fmt::format("wrote {} ({:.1f} MB); open it in a browser", options.output, 1e-6 * double(page.size())));
}

}  // namespace

void add_preview_command(CLI::App& app, Console& console) {
  const auto [command, options] = add_command(
      app, "preview", "Write an HTML page to look at a bone, place the glenoid and see the reamer before a run",
      console, preview_command);
  command
      ->add_option(
          "INPUT", options->input,
          "Scenario (YAML, or the name of a shipped one), CT (DICOM folder, NRRD, NIfTI, MetaImage), mesh (STL, "
          "OBJ, PLY), or VDB")
      ->required()
      ->transform(shipped_scenario_or_path, "");
  add_output(*command, options->output, "HTML file to write", "FILE.html")->required();
  command->add_option("--tool", options->tool, "Reamer of a bone without a scenario (default: the convex one)")
      ->type_name("MESH");
  command->add_option("--scale", options->scale, "Mesh without a scenario: file units to mm (default: by its length)");
  add_overrides(*command, options->overrides, "Set a key of the scenario, for example bone.mesh.repair=true");
  command->add_flag("--overwrite", options->overwrite, "Replace the output file");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
}

}  // namespace reamsim
