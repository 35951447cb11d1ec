// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <optional>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/first_scenario.h"
#include "sim/anatomy/find_glenoid.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/bone/bone.h"
#include "sim/scan/ct_import.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/scenario.h"
#include "sim/scene/contact_forecast.h"
#include "sim/scene/load_bone.h"

namespace reamsim {

namespace {

constexpr double kSearchVoxel_mm = 1;
constexpr std::size_t kMostJoints = 4;
constexpr double kLeastConfidence = 0.6;
constexpr double kRival = 0.8;  // of the confidence of the best place: another one that is as plausible

std::string text_of(const FacePlace& place) {
  const Vec3 &c = place.center_mm, &n = place.normal;
  return fmt::format("({:.1f}, {:.1f}, {:.1f}), {:.0f} x {:.0f} mm, normal ({:.2f}, {:.2f}, {:.2f}), confidence {:.2f}",
                     c.x(), c.y(), c.z(), place.height_mm, place.width_mm, n.x(), n.y(), n.z(), place.confidence);
}

/// A box round a scapula, whose medial side is not known yet. LPS.
void crop_round_glenoid(CtSettings& ct, const Vec3& near_mm) {
  ct.crop_min_mm = Vec3(near_mm - Vec3(120, 90, 160));
  ct.crop_max_mm = Vec3(near_mm + Vec3(120, 90, 70));
}

/// The places next to the heads in a scan.
std::vector<FacePlace> places_at_heads(const BoneSettings& settings, Diagnostics& report) {
  std::vector<ct::Joint> joints = joints_in_scan(settings, report);
  joints.resize(std::min(joints.size(), kMostJoints));
  std::vector<FacePlace> out;
  for (const ct::Joint& joint : joints) {
    BoneSettings near = settings;
    near.ct.separate = Separate::humerus;
    near.glenoid.near_mm = joint.near_mm;
    if (near.side == BodySide::unknown) near.side = BodySide::left;  // turns about the normal only
    crop_round_glenoid(near.ct, joint.near_mm);
    try {
      Diagnostics ignored;
      const Bone bone = load_bone(near, ignored);
      if (const auto place = place_at(bone.view(), bone.glenoid->bone_from_glenoid)) out.push_back(*place);
    } catch (const InputError&) {
      // A head without a glenoid, as in the hip.
    }
  }
  return out;
}

/// `of_bone` gets what is said of the bone.
std::vector<FacePlace> places_of(const BoneSettings& settings, Diagnostics& of_bone, Diagnostics& report) {
  std::vector<FacePlace> out;
  if (settings.source == BoneSource::ct) {
    out = places_at_heads(settings, of_bone);
    if (out.empty()) {
      report.note("no head of a humerus with a joint in the scan: the whole surface of the bone is searched");
    }
  }
  if (out.empty()) out = search_faces(load_bone(settings, of_bone).view());
  std::ranges::stable_sort(out, {}, [](const FacePlace& place) { return -place.confidence; });
  return out;
}

[[noreturn]] void refuse(const BoneSettings& settings, const std::string& found) {
  throw InputError({}, "--near", "missing, and " + found,
                   std::string(settings.source == BoneSource::mesh ? "check --scale; " : "") +
                       "give a point on the face of the glenoid, --near=X,Y,Z; `reamsim preview BONE -o bone.html` "
                       "shows coordinates");
}

/// The centre of the only plausible face.
Vec3 only_face(const BoneSettings& settings, Diagnostics& of_bone, Diagnostics& report) {
  std::vector<FacePlace> places = places_of(settings, of_bone, report);
  if (settings.source == BoneSource::ct) {
    const std::size_t others = std::erase_if(places, [&](const FacePlace& place) {
      const bool faces_left = place.normal.x() > 0;  // as a left glenoid does in LPS
      return settings.side != BodySide::unknown && faces_left != (settings.side == BodySide::left);
    });
    if (others > 0 && places.empty()) {
      refuse(settings, "the search found a glenoid of the other side only: check --side");
    }
  }
  if (places.empty()) refuse(settings, "the search found no face of a glenoid");
  const FacePlace& best = places.front();
  if (best.confidence < kLeastConfidence) {
    refuse(settings, "the search found no clear face of a glenoid; the best: " + text_of(best));
  }
  std::string rivals;
  for (std::size_t i = 1; i < places.size(); ++i) {
    if (places[i].confidence >= kRival * best.confidence) rivals += " or " + text_of(places[i]);
  }
  if (!rivals.empty())
    refuse(settings, "the search found several faces that may be the glenoid: " + text_of(best) + rivals);
  report.note("search for the glenoid: " + text_of(best) +
              (places.size() > 1 ? fmt::format("; the next best place has {:.2f}", places[1].confidence) : ""));
  return best.center_mm;
}

/// A point on the face of the glenoid: in a CT next to the heads of 16 to 32 mm radius, else anywhere on the surface. A
/// known side of a CT excludes the other. Throws InputError where no place resembles a glenoid, or several do.
Vec3 locate_glenoid(const BoneSettings& given, Diagnostics& report) {
  BoneSettings settings = given;
  settings.voxel_mm = kSearchVoxel_mm;
  Diagnostics of_bone;  // where a face is found, the bone is loaded once more with it, and its warnings come then
  try {
    return only_face(settings, of_bone, report);
  } catch (const InputError&) {
    for (const std::string& warning : of_bone.warnings) {  // once: the scan may have been read more often
      if (std::ranges::find(report.warnings, warning) == report.warnings.end()) report.warn(warning);
    }
    throw;
  }
}

namespace fs = std::filesystem;

constexpr double kThreshold_hu = 200;
constexpr const char* kFirstLine = "# Written by reamsim init.";

struct InitOptions {
  std::string input;
  std::string output;
  std::vector<double> near_mm;
  std::vector<std::string> markups;
  std::vector<std::string> points;  ///< "ROLE=LABEL"
  GlenoidSettings landmarks;        ///< of the markups
  std::string side;
  std::string tool;
  std::optional<double> scale;
  MeshScale used_scale;
  std::optional<double> threshold_hu;
  double voxel_mm = 0.4;
  std::vector<std::string> overrides;
  bool overwrite = false;
};

bool is_first_scenario(const std::string& path) {
  return read_file_start(path, std::string_view(kFirstLine).size()) == kFirstLine;
}

/// A path relative to the folder of the scenario.
std::string beside(const std::string& path, const std::string& scenario) {
  return fs::proximate(path, fs::absolute(scenario).parent_path()).string();
}

/// What the options say of the bone, without a glenoid.
BoneSettings settings_of(const InitOptions& options) {
  std::vector<std::string> more{"bone.surface_voxels=partial"};
  if (!options.side.empty()) more.push_back("bone.side=" + options.side);
  const std::vector<std::string> set = bone_keys(options.overrides);
  more.insert(more.end(), set.begin(), set.end());
  return first_bone(options.input, options.voxel_mm, options.used_scale.scale,
                    options.threshold_hu.value_or(kThreshold_hu), more);
}

/// The point of the options; without one it is searched. Rounded as it is written, so that a run of the scenario finds
/// what is found here: on some bones the face depends on the last digit.
Vec3 near_of(const InitOptions& options, Diagnostics& report) {
  const BoneSettings settings = settings_of(options);
  const Vec3 near_mm = !options.near_mm.empty()
                           ? Vec3(options.near_mm.at(0), options.near_mm.at(1), options.near_mm.at(2))
                       : settings.glenoid.near_mm ? *settings.glenoid.near_mm
                                                  : locate_glenoid(settings, report);
  return (near_mm * 100).array().round() / 100;
}

/// A bone, and the settings with which it was loaded.
struct LoadedBone {
  BoneSettings settings;
  Bone bone;
};

/// Without a humeral head in the scan, as in one of a specimen, nothing is cut.
LoadedBone load(const InitOptions& options, const Vec3& near_mm, Diagnostics& report) {
  BoneSettings settings = settings_of(options);
  settings.glenoid = options.landmarks;
  settings.glenoid.near_mm = near_mm;
  if (settings.side == BodySide::unknown) settings.side = BodySide::left;  // of a CT the normal says it
  const Diagnostics before = report;
  if (settings.source == BoneSource::ct) {
    crop_round_glenoid(settings.ct, near_mm);
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

/// Warns where the reamer meets no bone, or starts in bone because some lies behind its start.
void check_plunge(const LoadedBone& loaded, const PlungeSettings& plunge, const std::string& tool,
                  Diagnostics& report) {
  SimulationInput scene;
  scene.bone = loaded.bone;
  scene.scenario.bone = loaded.settings;
  scene.scenario.tool.mesh = tool;
  scene.tool = load_tool(scene.scenario.tool, loaded.settings.voxel_mm, ShellUse::none, report);
  const FirstContact contact =
      find_first_contact(scene.bone, scene.tool, plunge.entry_mm, plunge.axis, PoseFrame::glenoid);
  report.note(sentence_of(contact));
  MotionSettings motion;
  motion.frame = PoseFrame::glenoid;
  count_from(contact, motion.plunge.emplace(plunge));
  Diagnostics ignored;
  scene.motion = build_motion(motion, scene.bone.glenoid, ignored);
  warn_of_contact(scene, forecast_passes(scene), report);
}

/// Takes the landmarks of the markups, and says which.
void read_landmarks(InitOptions& options, const Console& console) {
  if (options.markups.empty()) return;
  const Landmarks found =
      find_landmarks(options.markups, options.points, from_name<BodySide>(options.side).value_or(BodySide::unknown));
  if (found.center && !options.near_mm.empty()) {
    throw InputError({}, "--near", "given beside the centre of the glenoid in the markups", "leave one of them out");
  }
  if (found.center) options.near_mm.assign(found.center->begin(), found.center->end());
  options.landmarks = found.glenoid;
  for (const std::string& line : found.found) console.say("markups: " + line);
}

/// Throws InputError for an input that is neither scan nor mesh, and for options that it cannot use.
void check_input(const InitOptions& options) {
  const BoneSource source = source_of_file(options.input);
  if (source == BoneSource::vdb) refuse_file(options.input, "is a VDB file", "expected a CT or a mesh");
  if (source == BoneSource::mesh && options.threshold_hu) {
    throw InputError({}, "--threshold-hu", "has no effect on a mesh", "leave it out");
  }
  if (source == BoneSource::mesh && options.side.empty()) {
    throw InputError({}, "--side", "missing", "left or right: a mesh does not say which");
  }
}

/// Writes the scenario. Where the options make it invalid, throws InputError and leaves an older file as it is.
void write_scenario_file(const std::string& path, const std::string& text) {
  try {
    replace_file(path, text, [](const std::string& unfinished) { parse_scenario(unfinished, {}); });
  } catch (const InputError& error) {
    std::vector<Mistake> mistakes = error.mistakes();
    for (Mistake& mistake : mistakes) mistake.where = {};  // in the temporary file, which is removed
    throw InputError(std::move(mistakes));
  }
}

void init_command(InitOptions options, const Console& console) {
  options.scale = scale_of(options.scale, options.overrides);
  if (options.side.empty()) options.side = value_set(options.overrides, "bone.side").value_or("");
  check_input(options);
  std::vector<std::string> inputs{options.input, options.tool};
  inputs.insert(inputs.end(), options.markups.begin(), options.markups.end());
  require_replaceable_file(options.output, "-o", options.overwrite, is_first_scenario, inputs);
  const std::string tool = reamer_or_own(options.tool);
  read_landmarks(options, console);
  options.used_scale = mesh_scale(options.input, options.scale, console);
  Diagnostics report;
  const auto warnings_of_error = print_on_error(report, console);
  LoadedBone loaded = load(options, near_of(options, report), report);
  FirstScenario first{.first_line = std::string(kFirstLine) + " docs/keys.md lists all keys.",
                      .bone = loaded.settings,
                      .bone_path = beside(options.input, options.output),
                      .tool_path = beside(tool, options.output),
                      .scale_note = options.used_scale.why,
                      .glenoid = loaded.bone.glenoid->bone_from_glenoid,
                      .plunge = first_plunge()};
  check_plunge(loaded, first.plunge, tool, report);
  // In a scan a left glenoid faces the patient's left, +x.
  if (options.side.empty()) first.bone.side = first.glenoid->linear()(0, 2) > 0 ? BodySide::left : BodySide::right;
  write_scenario_file(options.output, with_keys(text_of(first), options.overrides));
  for (const std::string& note : report.notes) console.say(note);
  console.print(report);
  console.say("wrote " + options.output + "; next: reamsim check " + options.output + ", then reamsim run " +
              options.output);
}

}  // namespace

void add_init_command(CLI::App& app, Console& console) {
  const auto [command, options] =
      add_command(app, "init", "Write a first scenario for a CT or mesh: the glenoid is found", console, init_command);
  command->add_option("INPUT", options->input, "CT (DICOM folder, NRRD, NIfTI, MetaImage) or mesh (STL, OBJ, PLY, VTP)")
      ->required();
  add_output(*command, options->output, "Scenario to write (YAML)", "FILE.yaml")->required();
  command
      ->add_option("--near", options->near_mm,
                   "A point within 8 mm of the centre of the glenoid's face, mm: LPS of a CT, the frame of a mesh "
                   "(default: searched)")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3);
  auto* markups =
      command
          ->add_option("--markups", options->markups,
                       "Landmarks of 3D Slicer (.mrk.json, .fcsv), found by their labels: glenoid centre, superior, "
                       "trigonum spinae, inferior angle, rim, points of version; repeatable")
          ->type_name("FILE")
          ->check(refuse_empty)
          ->expected(1)
          ->take_all();
  command
      ->add_option("--point", options->points,
                   "The point of the markups with this label is center, superior, trigonum, inferior_angle, rim, face, "
                   "anterior_margin, posterior_margin, medial_tip or vault_tip; repeatable")
      ->type_name("ROLE=LABEL")
      ->needs(markups)
      ->expected(1)
      ->take_all();
  command->add_option("--side", options->side, "Shoulder side, left or right (CT default: from the face normal)")
      ->check(CLI::IsMember({"left", "right"}));
  command->add_option("--tool", options->tool, "Mesh of the reamer; without it the convex reamer of reamsim")
      ->type_name("MESH");
  command->add_option("--scale", options->scale, "Mesh only: file units to mm (default: by its length)")
      ->check(CLI::Range(1e-6, 1e6));
  command->add_option("--threshold-hu", options->threshold_hu, "CT only: bone threshold, HU (default: 200)");
  command->add_option("--voxel-mm", options->voxel_mm, "Edge length of a voxel")->check(CLI::Range(0.01, 5.0));
  add_overrides(*command, options->overrides, "Set a key of the scenario, for example bone.mesh.repair=true");
  command->add_flag("--overwrite", options->overwrite, "Replace a scenario that init wrote");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
}

}  // namespace reamsim
