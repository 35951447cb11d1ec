// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "cli/input_kind.h"
#include "sim/anatomy/frame_check.h"
#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/bone/import_progress.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/vdb/vdb_archive.h"
#include "sim/record/checksum.h"
#include "sim/record/output_folder.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/shipped.h"
#include "sim/scene/load_bone.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

struct ImportOptions {
  std::string input;
  std::string output;
  std::vector<std::string> overrides;
  bool overwrite = false;
};

/// The bone settings of the scenario; for a mesh or a CT the defaults with `--set`. The surface voxels are those of a
/// run.
Scenario scenario_of(const ImportOptions& options) {
  Scenario scenario;
  if (is_scenario_name(options.input)) {
    scenario = parse_scenario(options.input, options.overrides);
  } else {
    const bool mesh = source_by_name(options.input) == BoneSource::mesh;
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
  if (lower_extension(options.output) != ".vdb") {
    throw InputError({options.output, 0, 0}, "", "output file does not end in .vdb", "use -o NAME.vdb");
  }
  require_replaceable_file(options.output, "-o", options.overwrite, is_vdb_of_reamsim, {options.input});
  const Scenario scenario = scenario_of(options);
  const BoneSettings& settings = scenario.bone;
  require_replaceable_file(options.output, "-o", options.overwrite, is_vdb_of_reamsim,
                           {settings.ct.path, settings.mesh.path, settings.vdb.path});
  const ForcedStop forced([unfinished = options.output + ".tmp"] {
    std::error_code ignored;
    fs::remove(unfinished, ignored);
    return StopOutcome{};
  });
  Progress bar(console, "import", "");
  ImportProgress progress(settings,
                          [&](double fraction, const std::string& stage) { bar.begin_part(fraction, stage); });
  Diagnostics report;
  const PrintOnError warnings_of_error(report, console);
  const Bone bone = load_checked(scenario, report, [&](BoneStage stage) { progress.begin(stage); });
  progress.begin(BoneStage::write);
  Metadata metadata{{"source", fs::path(options.input).filename().string()}, {"sha256", sha256_of(options.input)}};
  const Metadata anatomy = metadata_of({bone.glenoid, bone.landmarks, bone.side});
  metadata.insert(metadata.end(), anatomy.begin(), anatomy.end());
  write_bone_vdb(options.output, bone, {}, metadata);
  progress.finish();
  bar.finish();
  for (const auto& note : report.notes) console.say(note);
  report.notes.clear();
  console.print(report);
  console.say("wrote " + options.output);
}

}  // namespace

void add_import_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("import", "Convert a CT or mesh to a voxmap (VDB) for bone.source: vdb");
  auto options = std::make_shared<ImportOptions>();
  command
      ->add_option(
          "INPUT", options->input,
          "CT (DICOM folder, NRRD, NIfTI, MetaImage), mesh (STL, OBJ, PLY), or a scenario (YAML, or the name of a "
          "shipped one) whose bone is imported")
      ->required()
      ->transform(shipped_scenario_or_path, "");
  command->add_option("-o,--output", options->output, "VDB file to write")
      ->type_name("FILE.vdb")
      ->required()
      ->check(refuse_empty);
  command
      ->add_option("--set", options->overrides,
                   "Override a key of the bone section, for example bone.ct.threshold_hu=250; repeatable")
      ->type_name("KEY.PATH=VALUE")
      ->expected(1)
      ->take_all();
  command->add_flag("--overwrite", options->overwrite, "Replace the output file");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->callback([options, &console] { import_command(*options, console); });
}

}  // namespace reamsim
