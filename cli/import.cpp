#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/bone/bone_vdb.h"
#include "sim/bone/vdb_archive.h"
#include "sim/record/checksum.h"
#include "sim/record/output_folder.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

struct ImportOptions {
  std::string input;
  std::string output;
  std::vector<std::string> overrides;
  bool overwrite = false;
};

std::string extension(const std::string& path) {
  std::string text = fs::path(path).extension().string();
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// The bone section: of a scenario, or the defaults for a mesh or a CT with `--set` on top. Its surface is made as for
/// a run.
BoneSettings bone_settings(const ImportOptions& options) {
  const std::string kind = extension(options.input);
  if (kind == ".yaml" || kind == ".yml") {
    const Scenario scenario = parse_scenario(options.input, options.overrides);
    return with_surface_voxels(scenario.bone, scenario.cutting);
  }
  // VTK's surfaces are refused as meshes are, with what to do.
  const bool mesh = kind == ".stl" || kind == ".obj" || kind == ".ply" || kind == ".vtp" || kind == ".vtk";
  return with_surface_voxels(parse_bone_settings(mesh ? "mesh" : "ct", options.input, options.overrides), {});
}

void import_command(const ImportOptions& options, const Console& console) {
  if (extension(options.output) != ".vdb") {
    throw InputError({options.output, 0, 0}, "", "not a .vdb file", "expected -o NAME.vdb");
  }
  require_replaceable_file(options.output, "-o", options.overwrite, is_vdb_of_reamsim, {options.input});
  const BoneSettings settings = bone_settings(options);
  require_replaceable_file(options.output, "-o", options.overwrite, is_vdb_of_reamsim,
                           {settings.ct.path, settings.mesh.path, settings.vdb.path});
  Report report;
  const Bone bone = load_bone(settings, report);
  for (const auto& note : report.notes) console.say(note);
  report.notes.clear();
  console.tell(report);
  write_bone_vdb(options.output, bone.voxmap, {},
                 {{"source", fs::path(options.input).filename().string()}, {"sha256", sha256_of(options.input)}});
  console.say("wrote " + options.output);
}

}  // namespace

void add_import_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("import", "Turn a CT or a mesh into a voxmap (VDB) that bone.source: vdb reads");
  auto options = std::make_shared<ImportOptions>();
  command
      ->add_option("INPUT", options->input,
                   "DICOM folder, NRRD, NIfTI or MetaImage; STL, OBJ or PLY; or a scenario, whose bone is taken")
      ->required();
  command->add_option("-o,--output", options->output, "VDB file to write")->required();
  command
      ->add_option("--set", options->overrides,
                   "A key of the bone section, e.g. bone.voxel_mm=0.5 or bone.ct.threshold_hu=250; may be repeated")
      ->type_name("KEY.PATH=VALUE")
      ->expected(1)
      ->take_all();
  command->add_flag("--overwrite", options->overwrite, "Replace the output file");
  command->add_flag("--quiet", console.quiet, "Say nothing but warnings and errors");
  command->callback([options, &console] { import_command(*options, console); });
}

}  // namespace reamsim
