#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "cli/first_scenario.h"
#include "cli/input_kind.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/bone/bone.h"
#include "sim/predict/contact_forecast.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFirstLine = "# Written by reamsim init.";

struct InitOptions {
  std::string input;
  std::string output;
  std::vector<double> near_mm;
  std::string side;
  std::string tool;
  double scale = 1;
  double threshold_hu = 200;
  double voxel_mm = 0.4;
  bool overwrite = false;
};

bool is_mesh(const std::string& path) {
  return source_by_name(path) == BoneSource::mesh;
}

bool is_first_scenario(const std::string& path) {
  return read_file_start(path, std::string_view(kFirstLine).size()) == kFirstLine;
}

/// The reamer of the options, or that of the program.
std::string tool_of(const InitOptions& options) {
  const std::string tool = options.tool.empty() ? own_reamer() : options.tool;
  if (!tool.empty()) return tool;
  throw InputError({}, "--tool", "missing, and the program has no reamer of its own", "give the mesh of a reamer");
}

/// A path as a YAML text, relative to the folder of the scenario.
std::string yaml_path(const std::string& path, const std::string& scenario) {
  return yaml_quoted(fs::proximate(path, fs::absolute(scenario).parent_path()).string());
}

std::string yaml_vector(const Vec3& v, int digits) {
  return fmt::format("[{:.{}f}, {:.{}f}, {:.{}f}]", v.x(), digits, v.y(), digits, v.z(), digits);
}

/// What the options say of the bone.
BoneSettings settings_of(const InitOptions& options, bool separate) {
  const bool mesh = is_mesh(options.input);
  const Vec3 near(options.near_mm.at(0), options.near_mm.at(1), options.near_mm.at(2));
  std::vector<std::string> set{"bone.glenoid.near_mm=" + yaml_vector(near, 6),
                               "bone.side=" + (options.side.empty() ? "left" : options.side),
                               fmt::format("bone.voxel_mm={}", options.voxel_mm), "bone.surface_voxels=partial"};
  if (mesh) set.push_back(fmt::format("bone.mesh.scale={}", options.scale));
  if (!mesh) set.push_back(fmt::format("bone.ct.threshold_hu={}", options.threshold_hu));
  if (separate) set.emplace_back("bone.ct.separate=humerus");
  BoneSettings out = parse_bone_settings(mesh ? "mesh" : "ct", options.input, set);
  if (mesh) return out;
  // Round a scapula; the medial side is not known yet.
  out.ct.crop_min_mm = Vec3(near - Vec3(120, 90, 160));
  out.ct.crop_max_mm = Vec3(near + Vec3(120, 90, 70));
  return out;
}

/// A bone, and the settings with which it was loaded.
struct LoadedBone {
  BoneSettings settings;
  Bone bone;
};

/// Without a humeral head in the scan, as in one of a specimen, nothing is cut.
LoadedBone load(const InitOptions& options, Report& report) {
  if (!is_mesh(options.input)) {
    try {
      BoneSettings settings = settings_of(options, true);
      return {settings, load_bone(settings, report)};
    } catch (const InputError& error) {
      const auto& mistakes = error.mistakes();
      if (mistakes.empty() || mistakes.front().key != "bone.ct.separate") throw;
      report = {};
      report.note("no head of a humerus next to the glenoid: nothing is cut");
    }
  }
  BoneSettings settings = settings_of(options, false);
  return {settings, load_bone(settings, report)};
}

/// left or right; in a scan a left glenoid faces the patient's left, +x.
std::string side_of(const InitOptions& options, const Bone& bone) {
  if (!options.side.empty()) return options.side;
  return bone.glenoid->bone_from_glenoid.linear()(0, 2) > 0 ? "left" : "right";
}

/// Distance of the reamer's start before its first contact, mm.
constexpr double kApproach_mm = 2;

/// Warns where the reamer meets no bone, or starts in bone because some lies behind its start.
void check_plunge(const LoadedBone& loaded, const std::string& tool, Report& report) {
  ReamingScene scene;
  scene.bone = loaded.bone;
  scene.scenario.bone = loaded.settings;
  scene.scenario.tool.mesh = tool;
  scene.tool = load_tool(scene.scenario.tool, loaded.settings.voxel_mm, ShellUse::none, report);
  MotionSettings motion;
  motion.frame = PoseFrame::glenoid;
  motion.plunge.emplace().approach_mm = kApproach_mm;
  const FirstContact contact = find_first_contact(scene.bone, scene.tool, *motion.plunge, motion.frame);
  report.note(sentence_of(contact));
  motion.plunge = counted_from(contact, *motion.plunge);
  Report ignored;
  scene.motion = build_motion(motion, scene.bone.glenoid, ignored);
  warn_of_contact(scene, forecast_contact(scene), report);
}

std::string source_text(const InitOptions& options, const BoneSettings& settings) {
  const std::string path = yaml_path(options.input, options.output);
  if (settings.source == BoneSource::mesh) {
    return fmt::format(
        "  mesh:\n    path: {}\n    scale: {}                  # file units to mm\n"
        "    cortical_mm: 1.5          # a mesh has no density: a shell of cortical bone on trabecular bone\n"
        "    cortical_hu: 1500\n    trabecular_hu: 300\n",
        path, settings.mesh.scale);
  }
  return fmt::format(
      "  ct:\n    path: {}\n    crop_min_mm: {}   # a box round the scapula, LPS\n    crop_max_mm: {}\n"
      "    threshold_hu: {}          # least radiodensity of bone; lower it where the surface has holes\n"
      "    separate: {}         # cuts the head of the humerus off along the joint gap\n",
      path, yaml_vector(*settings.ct.crop_min_mm, 1), yaml_vector(*settings.ct.crop_max_mm, 1),
      settings.ct.threshold_hu, name_of(settings.ct.separate));
}

std::string glenoid_text(const LoadedBone& loaded) {
  const Rigid& frame = loaded.bone.glenoid->bone_from_glenoid;
  const Mat3 axes = frame.linear();
  std::string out = fmt::format(
      "  glenoid:\n    near_mm: {}   # the face is found round this point\n"
      "    # Found: center_mm: {}, normal: {}.\n",
      yaml_vector(*loaded.settings.glenoid.near_mm, 2), yaml_vector(frame.translation(), 2),
      yaml_vector(axes.col(2), 4));
  out += loaded.settings.source == BoneSource::mesh
             ? fmt::format("    superior: {}   # towards the narrow end of the face: check it\n",
                           yaml_vector(axes.col(1), 4))
             : fmt::format("    # superior: {}\n", yaml_vector(axes.col(1), 4));
  return out;
}

std::string scenario_text(const InitOptions& options, const LoadedBone& loaded, const std::string& tool) {
  return fmt::format(
      "{} docs/formats.md lists all keys.\n"
      "version: 2\n\nbone:\n  source: {}\n  side: {}\n  voxel_mm: {}\n{}{}\n"
      "tool:\n  mesh: {}\n\n"
      "motion:\n  frame: glenoid            # entry and axis are in the glenoid frame: +z out of the face, +y "
      "superior\n"
      "  plunge:\n    entry_mm: [0, 0, 0]     # the line of the plunge passes the centre of the face\n"
      "    axis: [0, 0, -1]\n    from: contact           # of the reamer with the bone, found before the run\n"
      "    approach_mm: {:g}          # before the contact\n    feed_mm_s: 1\n    depth_mm: 3             # beyond the "
      "contact\n"
      "    dwell_s: 0.2\n    retract_mm: 12\n    retract_mm_s: 20\n    spin_rpm: 250\n\n"
      "render:\n  cameras: [glenoid, section, oblique]\n",
      kFirstLine, name_of(loaded.settings.source), side_of(options, loaded.bone), options.voxel_mm,
      source_text(options, loaded.settings), glenoid_text(loaded), yaml_path(tool, options.output), kApproach_mm);
}

void init_command(const InitOptions& options, const Console& console) {
  if (is_mesh(options.input) && options.side.empty()) {
    throw InputError({}, "--side", "missing", "left or right: a mesh does not say which");
  }
  require_replaceable_file(options.output, "-o", options.overwrite, is_first_scenario, {options.input, options.tool});
  const std::string tool = tool_of(options);
  Report report;
  const LoadedBone loaded = load(options, report);
  check_plunge(loaded, tool, report);
  replace_file(options.output, scenario_text(options, loaded, tool));
  for (const std::string& note : report.notes) console.say(note);
  report.notes.clear();
  console.print(report);
  parse_scenario(options.output, {});
  console.say("wrote " + options.output + "; next: reamsim check " + options.output + ", then reamsim run " +
              options.output);
}

}  // namespace

void add_init_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("init", "Write a first scenario for a CT or mesh from one point of the glenoid");
  auto options = std::make_shared<InitOptions>();
  command->add_option("INPUT", options->input, "CT (DICOM folder, NRRD, NIfTI, MetaImage) or mesh (STL, OBJ, PLY)")
      ->required();
  command->add_option("-o,--output", options->output, "Scenario to write (YAML)")->required()->check(refuse_empty);
  command
      ->add_option("--near", options->near_mm,
                   "A point within 8 mm of the centre of the glenoid's face, mm: LPS of a CT, the frame of a mesh")
      ->required()
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3);
  command->add_option("--side", options->side, "left or right; of a CT without it by the normal of the face")
      ->check(CLI::IsMember({"left", "right"}));
  command->add_option("--tool", options->tool, "Mesh of the reamer; without it the convex reamer of reamsim");
  command->add_option("--scale", options->scale, "Of a mesh: file units to mm")->check(CLI::Range(1e-6, 1e6));
  command->add_option("--threshold-hu", options->threshold_hu, "Of a CT: least radiodensity of bone");
  command->add_option("--voxel-mm", options->voxel_mm, "Edge length of a voxel")->check(CLI::Range(0.01, 5.0));
  command->add_flag("--overwrite", options->overwrite, "Replace a scenario that init wrote");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->callback([options, &console] { init_command(*options, console); });
}

}  // namespace reamsim
