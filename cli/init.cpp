// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>

#include "cli/commands.h"
#include "cli/first_scenario.h"
#include "cli/input_kind.h"
#include "cli/locate_glenoid.h"
#include "cli/mesh_scale.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/bone/bone.h"
#include "sim/scenario/parse.h"
#include "sim/scene/contact_forecast.h"
#include "sim/scene/load_bone.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

constexpr double kThreshold_hu = 200;
constexpr const char* kFirstLine = "# Written by reamsim init.";

struct InitOptions {
  std::string input;
  std::string output;
  std::vector<double> near_mm;
  std::string side;
  std::string tool;
  std::optional<double> scale;
  MeshScale used_scale;
  std::optional<double> threshold_hu;
  double voxel_mm = 0.4;
  bool overwrite = false;
};

bool is_first_scenario(const std::string& path) {
  return read_file_start(path, std::string_view(kFirstLine).size()) == kFirstLine;
}

/// The reamer of the options, or that of the program.
std::string tool_of(const InitOptions& options) {
  const std::string tool = options.tool.empty() ? own_reamer() : options.tool;
  if (!tool.empty()) return tool;
  throw InputError({}, "--tool", "missing, and the program has no reamer of its own", "give the mesh of a reamer");
}

/// A path relative to the folder of the scenario.
std::string beside(const std::string& path, const std::string& scenario) {
  return fs::proximate(path, fs::absolute(scenario).parent_path()).string();
}

/// What the options say of the bone, without a glenoid.
BoneSettings settings_of(const InitOptions& options) {
  std::vector<std::string> more{"bone.surface_voxels=partial"};
  if (!options.side.empty()) more.push_back("bone.side=" + options.side);
  return first_bone(options.input, options.voxel_mm, options.used_scale.scale,
                    options.threshold_hu.value_or(kThreshold_hu), more);
}

/// The point of the options; without one it is searched. Rounded as it is written, so that a run of the scenario finds
/// what is found here: on some bones the face depends on the last digit.
Vec3 near_of(const InitOptions& options, Diagnostics& report) {
  const Vec3 near_mm = options.near_mm.empty()
                           ? locate_glenoid(settings_of(options), report)
                           : Vec3(options.near_mm.at(0), options.near_mm.at(1), options.near_mm.at(2));
  return (near_mm * 100).array().round() / 100;
}

BoneSettings settings_near(const InitOptions& options, const Vec3& near_mm) {
  BoneSettings out = settings_of(options);
  out.glenoid.near_mm = near_mm;
  if (out.side == BodySide::unknown) out.side = BodySide::left;  // of a CT the normal says it
  if (out.source == BoneSource::ct) crop_round_glenoid(out.ct, near_mm);
  return out;
}

/// A bone, and the settings with which it was loaded.
struct LoadedBone {
  BoneSettings settings;
  Bone bone;
};

/// Without a humeral head in the scan, as in one of a specimen, nothing is cut.
LoadedBone load(const InitOptions& options, const Vec3& near_mm, Diagnostics& report) {
  BoneSettings settings = settings_near(options, near_mm);
  const Diagnostics before = report;
  if (settings.source == BoneSource::ct) {
    settings.ct.separate = Separate::humerus;
    try {
      return {settings, load_bone(settings, report)};
    } catch (const InputError& error) {
      const auto& mistakes = error.mistakes();
      if (mistakes.empty() || mistakes.front().key != "bone.ct.separate") throw;
      report = before;
      report.note("no head of a humerus next to the glenoid: nothing is cut");
      settings.ct.separate = Separate::none;
    }
  }
  return {settings, load_bone(settings, report)};
}

/// In a scan a left glenoid faces the patient's left, +x.
BodySide side_of(const InitOptions& options, const LoadedBone& loaded) {
  if (!options.side.empty()) return loaded.settings.side;
  return loaded.bone.glenoid->bone_from_glenoid.linear()(0, 2) > 0 ? BodySide::left : BodySide::right;
}

/// Warns where the reamer meets no bone, or starts in bone because some lies behind its start.
void check_plunge(const LoadedBone& loaded, const PlungeSettings& plunge, const std::string& tool,
                  Diagnostics& report) {
  SimulationInput scene;
  scene.bone = loaded.bone;
  scene.scenario.bone = loaded.settings;
  scene.scenario.tool.mesh = tool;
  scene.tool = load_tool(scene.scenario.tool, loaded.settings.voxel_mm, ShellUse::none, report);
  const FirstContact contact = find_first_contact(scene.bone, scene.tool, plunge, PoseFrame::glenoid);
  report.note(sentence_of(contact));
  MotionSettings motion;
  motion.frame = PoseFrame::glenoid;
  motion.plunge = counted_from(contact, plunge);
  Diagnostics ignored;
  scene.motion = build_motion(motion, scene.bone.glenoid, ignored);
  warn_of_contact(scene, forecast_contact(scene), report);
}

/// Throws InputError for an input that is neither scan nor mesh, and for options that it cannot use.
void check_input(const InitOptions& options) {
  const BoneSource source = source_by_name(options.input);
  if (source == BoneSource::vdb) {
    throw InputError({options.input, 0, 0}, "", "is a VDB file", "expected a CT or a mesh");
  }
  if (source == BoneSource::mesh && options.threshold_hu) {
    throw InputError({}, "--threshold-hu", "has no effect on a mesh", "leave it out");
  }
  if (source == BoneSource::mesh && options.side.empty()) {
    throw InputError({}, "--side", "missing", "left or right: a mesh does not say which");
  }
}

void init_command(InitOptions options, const Console& console) {
  check_input(options);
  require_replaceable_file(options.output, "-o", options.overwrite, is_first_scenario, {options.input, options.tool});
  const std::string tool = tool_of(options);
  options.used_scale = mesh_scale(options.input, options.scale, console);
  Diagnostics report;
  const PrintOnError warnings_of_error(report, console);
  LoadedBone loaded = load(options, near_of(options, report), report);
  FirstScenario first{.first_line = std::string(kFirstLine) + " docs/keys.md lists all keys.",
                      .bone = loaded.settings,
                      .bone_path = beside(options.input, options.output),
                      .tool_path = beside(tool, options.output),
                      .scale_note = options.used_scale.why,
                      .glenoid = loaded.bone.glenoid->bone_from_glenoid,
                      .plunge = first_plunge()};
  check_plunge(loaded, first.plunge, tool, report);
  first.bone.side = side_of(options, loaded);
  replace_file(options.output, text_of(first));
  for (const std::string& note : report.notes) console.say(note);
  report.notes.clear();
  console.print(report);
  parse_scenario(options.output, {});
  console.say("wrote " + options.output + "; next: reamsim check " + options.output + ", then reamsim run " +
              options.output);
}

}  // namespace

void add_init_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("init", "Write a first scenario for a CT or mesh: the glenoid is found");
  auto options = std::make_shared<InitOptions>();
  command->add_option("INPUT", options->input, "CT (DICOM folder, NRRD, NIfTI, MetaImage) or mesh (STL, OBJ, PLY)")
      ->required();
  command->add_option("-o,--output", options->output, "Scenario to write (YAML)")
      ->type_name("FILE.yaml")
      ->required()
      ->check(refuse_empty);
  command
      ->add_option("--near", options->near_mm,
                   "A point within 8 mm of the centre of the glenoid's face, mm: LPS of a CT, the frame of a mesh "
                   "(default: searched)")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3);
  command->add_option("--side", options->side, "Shoulder side, left or right (CT default: from the face normal)")
      ->check(CLI::IsMember({"left", "right"}));
  command->add_option("--tool", options->tool, "Mesh of the reamer; without it the convex reamer of reamsim")
      ->type_name("MESH");
  command->add_option("--scale", options->scale, "Mesh only: file units to mm (default: by its length)")
      ->check(CLI::Range(1e-6, 1e6));
  command->add_option("--threshold-hu", options->threshold_hu, "CT only: bone threshold, HU (default: 200)");
  command->add_option("--voxel-mm", options->voxel_mm, "Edge length of a voxel")->check(CLI::Range(0.01, 5.0));
  command->add_flag("--overwrite", options->overwrite, "Replace a scenario that init wrote");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->callback([options, &console] { init_command(*options, console); });
}

}  // namespace reamsim
