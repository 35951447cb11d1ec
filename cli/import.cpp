// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "sim/anatomy/find_glenoid.h"
#include "sim/base/checksum.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/bone/bone.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/vdb/grids.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/record/output_folder.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/scenario.h"
#include "sim/scene/bone_store.h"
#include "sim/scene/load_bone.h"

namespace reamsim {

namespace {

/// The usual time of a stage, s, at voxels of v mm: fixed + per_area/v² + per_volume/v³.
///
/// Measured as processor time of the main thread and of the process that reads files, or half of that of all threads
/// where this is more, as on two cores of an AMD EPYC: `reamsim import` of the public shoulder CT (with and without its
/// crop), of the public scapula mesh (with and without near_mm), of the VDB of that mesh and of the phantom of
/// trajectories/default.yaml, at 0.8, 0.4 and 0.25 mm. The forms fit within 0.1 s or a fifth. Only ratios count.
struct StageTime {
  BoneSource source;
  BoneStage stage;
  const char* name;
  double fixed_s, per_area_s, per_volume_s;
};

constexpr StageTime kStages[]{
    {BoneSource::ct, BoneStage::read, "reading the scan", 0.2, 0, 0},
    {BoneSource::ct, BoneStage::filter, "filtering the scan", 1.2, 0, 0},
    {BoneSource::ct, BoneStage::segment, "segmenting the bone", 0.6, 0, 0},
    {BoneSource::ct, BoneStage::correct_density, "correcting the density of its boundary", 0.55, 0, 0},
    {BoneSource::ct, BoneStage::voxels, "making voxels", 0.65, 0, 0.036},
    {BoneSource::ct, BoneStage::anatomy, "placing the glenoid", 0.01, 0, 0},
    {BoneSource::ct, BoneStage::write, "writing the VDB", 0, 0.09, 0},
    {BoneSource::mesh, BoneStage::read, "reading the mesh", 0.01, 0, 0},
    {BoneSource::mesh, BoneStage::distances, "computing distances to its surface", 0.17, 0, 0.031},
    {BoneSource::mesh, BoneStage::voxels, "making voxels", 0.01, 0, 0.007},
    {BoneSource::mesh, BoneStage::anatomy, "placing the glenoid", 0.01, 0, 0},
    {BoneSource::mesh, BoneStage::write, "writing the VDB", 0, 0.1, 0},
    {BoneSource::vdb, BoneStage::read, "reading the VDB", 0, 0.03, 0},
    {BoneSource::vdb, BoneStage::anatomy, "placing the glenoid", 0.01, 0, 0},
    {BoneSource::vdb, BoneStage::write, "writing the VDB", 0, 0.09, 0},
    {BoneSource::phantom, BoneStage::voxels, "making voxels", 0.1, 0, 0.0275},
    {BoneSource::phantom, BoneStage::anatomy, "placing the glenoid", 0.01, 0, 0},
    {BoneSource::phantom, BoneStage::write, "writing the VDB", 0, 0.03, 0}};

/// Shows on `bar` how far `reamsim import` is. A stage that this bone does not have is passed over.
StageSink progress_on(Progress& bar, const BoneSettings& settings) {
  struct Part {
    BoneStage stage;
    const char* name;
    double before_s;
  };
  const double area = std::pow(settings.voxel_mm, -2), volume = std::pow(settings.voxel_mm, -3);
  std::vector<Part> parts;
  double total_s = 0;
  for (const StageTime& usual : kStages) {
    if (usual.source != settings.source) continue;
    if (usual.stage == BoneStage::filter && settings.ct.filter == CtFilter::none) continue;
    parts.push_back({usual.stage, usual.name, total_s});
    const bool face = usual.stage == BoneStage::anatomy && settings.glenoid.near_mm;  // is searched round near_mm
    total_s += face ? 0.3 + 0.011 * volume : usual.fixed_s + usual.per_area_s * area + usual.per_volume_s * volume;
  }
  return [&bar, parts, total_s](BoneStage stage) {
    const auto part = std::ranges::find(parts, stage, &Part::stage);
    if (part != parts.end()) bar.update_part(part->before_s / total_s, part->name, true);
  };
}

namespace fs = std::filesystem;

struct ImportOptions {
  std::string input;
  std::string output;
  std::vector<std::string> overrides;
  bool overwrite = false;
};

/// That of the input, or for a mesh or a CT the defaults with `--set`. The surface voxels are those of a run.
Scenario scenario_of(const ImportOptions& options) {
  Scenario scenario;
  if (is_scenario_name(options.input)) {
    scenario = parse_scenario(options.input, options.overrides);
  } else {
    const bool mesh = source_of_file(options.input) == BoneSource::mesh;
    scenario.bone = parse_bone_settings(mesh ? "mesh" : "ct", options.input, options.overrides);
  }
  scenario.bone = with_surface_voxels(scenario.bone, scenario.cutting);
  return scenario;
}

/// Throws InputError also for a glenoid frame that contradicts the bone, because the file would store it.
Bone load_checked(const Scenario& scenario, Diagnostics& report, const StageSink& stages) {
  try {
    Bone bone = load_bone(scenario.bone, report, stages);
    MistakeList mistakes;
    check_glenoid_frame(bone, scenario.bone, mistakes, report);
    mistakes.throw_if_any();
    return bone;
  } catch (const InputError& error) {
    throw scenario.keys.located(error);
  }
}

void import_command(const ImportOptions& options, const Console& console) {
  if (lower_extension(options.output) != ".vdb")
    refuse_file(options.output, "output file does not end in .vdb", "use -o NAME.vdb");
  require_replaceable_file(options.output, "-o", options.overwrite, is_vdb_of_reamsim, {options.input});
  const Scenario scenario = scenario_of(options);
  const BoneSettings& settings = scenario.bone;
  require_replaceable_file(options.output, "-o", options.overwrite, is_vdb_of_reamsim,
                           {settings.ct.path, settings.mesh.path, settings.vdb.path});
  const auto forced = removing_unfinished(options.output);
  Progress bar(console, "import", "");
  const StageSink stages = progress_on(bar, settings);
  Diagnostics report;
  const auto warnings_of_error = print_on_error(report, console);
  const Bone bone = load_checked(scenario, report, stages);
  stages(BoneStage::write);
  Metadata metadata{{"source", fs::path(options.input).filename().string()}, {"sha256", sha256_of(options.input)}};
  const Metadata anatomy = metadata_of({bone.glenoid, bone.landmarks, bone.side});
  metadata.insert(metadata.end(), anatomy.begin(), anatomy.end());
  write_bone_vdb(options.output, bone, {}, metadata);
  bar.update_part(1, "", true);
  bar.finish();
  for (const auto& note : report.notes) console.say(note);
  console.print(report);
  console.say("wrote " + options.output);
}

}  // namespace

void add_import_command(CLI::App& app, Console& console) {
  const auto [command, options] = add_command(
      app, "import", "Convert a CT or mesh to a voxmap (VDB) for bone.source: vdb", console, import_command);
  command
      ->add_option(
          "INPUT", options->input,
          "CT (DICOM folder, NRRD, NIfTI, MetaImage), mesh (STL, OBJ, PLY, VTP), or a scenario (YAML, or the name of a "
          "shipped one) whose bone is imported")
      ->required()
      ->transform(shipped_scenario_or_path, "");
  add_output(*command, options->output, "VDB file to write", "FILE.vdb")->required();
  add_overrides(*command, options->overrides,
                "Override a key of the bone section, for example bone.ct.threshold_hu=250");
  command->add_flag("--overwrite", options->overwrite, "Replace the output file");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
}

void add_cache_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("cache", "Show or empty the store of bones that were loaded before");
  auto empty = std::make_shared<bool>(false);
  command->add_flag("--clear", *empty, "Remove these bones");
  command->callback([empty, &console] {
    const std::filesystem::path folder = BoneStore::usual_folder(true);
    if (folder.empty()) return console.say("no bones are stored: neither XDG_CACHE_HOME nor HOME is set");
    const bool off = BoneStore::usual_folder().empty();
    const BoneStore store(folder);
    if (*empty) store.clear();
    const auto [bones, bytes] = store.size();
    console.say(fmt::format("{}: {} bones, {} of at most {}{}", folder.string(), bones, megabytes(bytes),
                            megabytes(BoneStore::kMostBytes), off ? "; REAMSIM_CACHE=off: no bone is added" : ""));
  });
}

}  // namespace reamsim
