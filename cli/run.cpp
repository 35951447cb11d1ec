// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <tuple>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/environment.h"
#include "cli/outputs.h"
#include "render/pictures/figures.h"
#include "render/render.h"
#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/base/text.h"
#include "sim/record/output_folder.h"
#include "sim/run/cost_estimate.h"
#include "sim/run/simulation.h"
#include "sim/scenario/parse.h"
#include "sim/scene/clearance.h"
#include "sim/scene/contact_forecast.h"

namespace reamsim {

namespace {

/// The arguments that `run` and `check` share.
struct ScenarioOptions {
  std::string file;
  std::vector<std::string> overrides;
  std::string device;
  std::string engine;
  bool draft = false;

  void add_to(CLI::App& command) {
    command.add_option("SCENARIO", file, "Scenario file (YAML), or the name of a shipped one")
        ->required()
        ->transform(shipped<ShippedKind::scenario>, "");
    add_overrides(command, overrides, "Override a key of the scenario, for example bone.voxel_mm=0.4");
    command
        .add_option("--device", device, "auto, serial, or part of PLATFORM: NAME of an OpenCL device (#2: the second)")
        ->type_name("NAME");
    command.add_option("--engine", engine, "Engine (default: that of the scenario)")
        ->type_name("auto|exact|bricked|direct|octree|implicit");
  }

  /// The scenario with these, and with the tuning of the environment, which tests use. Throws InputError.
  [[nodiscard]] Scenario parse() const {
    std::vector<std::string> all = overrides;
    for (const auto& [option, value, key] :
         {std::tuple{"--device", &device, "engine.device="}, std::tuple{"--engine", &engine, "engine.type="}}) {
      if (value->empty()) continue;
      const auto sets_it = [prefix = key](const std::string& set) { return set.starts_with(prefix); };
      if (std::ranges::any_of(overrides, sets_it))
        throw InputError({}, option, std::string("given beside --set ") + key + "...", "give one of them");
      all.push_back(key + *value);
    }
    if (draft) {
      const std::vector<std::string> coarse = draft_overrides(parse_scenario(file, all));
      all.insert(all.begin(), coarse.begin(), coarse.end());  // those of the user count
    }
    Scenario scenario = parse_scenario(file, all);
    scenario.engine.tuning = tuning_of_environment();
    return scenario;
  }
};

struct RunOptions {
  ScenarioOptions scenario;
  std::string output;
  bool overwrite = false;
  bool resume = false;
};

void run_command(const RunOptions& options, const Console& console) {
  RunRequest request;
  request.scenario = options.scenario.parse();
  request.dir = options.output.empty() ? results_dir(request.scenario) : options.output;
  request.overwrite = options.overwrite;
  request.resume = options.resume;
  if (options.scenario.draft) {
    const BoneSettings& bone = request.scenario.bone;
    request.warnings.push_back(
        "a draft with few pictures, one plot, and without report, meshes and reamed.vti" +
        (bone.source == BoneSource::vdb
             ? ""
             : fmt::format("; with voxels of {:g} mm, forces and volumes differ from those of the run without --draft",
                           bone.voxel_mm)));
  }
  require_film_program(request.scenario.render);
  const auto kernels = prepare_opencl(request.scenario.engine.device, console);
  RunResources resources;
  RunConsole monitor(console);
  Outputs pictures(console, options.scenario.draft);
  run_scenario(request, resources, monitor, &pictures);
}

/// Duration of the timed part of the simulation.
constexpr double kCheckTiming_s = 1;
/// Time of a picture of 1920 × 1080, measured on two cores as docs/scenario.md describes.
constexpr double kPicture_s = 0.47;

void note_compliance(const ComplianceSettings& springs, Diagnostics& report) {
  const Vec3& k = springs.stiffness_n_mm;
  report.note(
      fmt::format("compliance: {:g}, {:g} and {:g} N/mm along x, y and z of the tool{}, damping {:g} N s/mm; the "
                  "deflection is known only when it is run, and contact and memory are those of the planned path",
                  k.x(), k.y(), k.z(), k.maxCoeff() < ComplianceSettings::kRigid_n_mm ? "" : " (1e+06: rigid)",
                  springs.damping_n_s_mm));
}

/// Figures of --json; the notes have the same.
using Json = nlohmann::ordered_json;

void note_cost(const SimulationInput& scene, Diagnostics& report, Json& figures) {
  const std::int64_t frames = scene.last_frame(), substeps = count_all_substeps(scene);
  if (const auto& push = scene.motion.push) {
    report.note(fmt::format(
        "motion: a push of at most {} frames ({:g} s at {:g} Hz); its feed is known only when it is run, and contact, "
        "memory and time are estimated for the way of a push without resistance",
        push->last_frame(), push->settings().time_s, scene.motion.frame_rate_hz));
  }
  if (const auto& springs = scene.scenario.motion.compliance) note_compliance(*springs, report);
  const VoxelGrid& grid = scene.bone.voxmap->grid;
  report.note(fmt::format("motion: {} frames ({:.3f} s at {:g} Hz), {} substeps", frames,
                          static_cast<double>(frames) * scene.motion.frame_s(), scene.motion.frame_rate_hz, substeps));
  if (const PointShell& shell = scene.tool.shell; !shell.codes.empty()) {
    report.note(fmt::format("tool: {} shell points, spacing {:g} mm", shell.codes.size(), shell.cell_mm));
  }
  report.note("engine: " + name_of(engine_of(scene.scenario)));
  figures["engine"] = name_of(engine_of(scene.scenario));
  figures["frames"] = frames;
  figures["frame_rate_hz"] = scene.motion.frame_rate_hz;
  figures["substeps"] = substeps;
  figures["voxel_mm"] = grid.voxel_mm;
  figures["dims"] = {grid.dims.x(), grid.dims.y(), grid.dims.z()};
  figures["bone_voxels"] = scene.bone.view().count_bone();
  figures["bone_mm3"] = scene.bone.view().bone_mm3();
}

/// The pictures of a run, and their time.
std::string picture_time(const SimulationInput& scene, double load_s, Json& figures) {
  const RenderSettings& render = scene.scenario.render;
  const std::vector<std::int64_t> frames = picture_frames(render, scene.last_frame(), scene.contact);
  const int pictures = render.enabled ? count_pictures({render}, frames, scene.contact) : 0;
  const double pixels = double(render.width_px) * render.height_px * render.supersampling * render.supersampling;
  const double frame_height = std::min(1.0, double(render.frame_height_px) / render.height_px);
  const auto cameras = static_cast<int>(render.cameras.size() + render.user_cameras.size());
  const int stills = render.enabled ? cameras * int(still_frames(frames, render, scene.contact).size()) : 0;
  const double full_pictures = pictures - stills * (1 - frame_height * frame_height);
  const double pictures_s = full_pictures * kPicture_s * pixels / (1920 * 1080);
  figures["pictures"] = pictures;
  figures["pictures_s"] = pictures_s;
  figures["load_s"] = load_s;
  return fmt::format("time: about {:.2g} s for {} pictures, rendered during and after the simulation; {:.2g} s to load",
                     pictures_s, pictures, load_s);
}

/// Estimates of all passes.
struct PassPlans {
  MemoryPlan memory;  ///< the most of any pass
  TimePlan time;
  std::string device;
  double load_s = 0;  ///< of the engines
};

/// Adds the present pass. Times a part of its frames, which reams the bone of the scene.
void add_pass(SimulationInput& scene, double budget_s, PassPlans& plans) {
  const MemoryPlan memory = plan_memory(scene);
  plans.memory.device_bytes = std::max(plans.memory.device_bytes, memory.device_bytes);
  plans.memory.process_bytes = std::max(plans.memory.process_bytes, memory.process_bytes);
  const Stopwatch watch;
  const std::unique_ptr<Engine> engine = load_engine(scene);
  plans.load_s += watch.seconds();
  plans.device = engine->device();
  const TimePlan time = plan_time(scene, *engine, budget_s);
  plans.time.simulate_s += time.simulate_s;
  plans.time.timed_frames += time.timed_frames;
  plans.time.windows += time.windows;
}

/// Estimates memory and time, with the mistakes that the engine finds. Leaves the last pass in the scene.
void note_plans(SimulationInput& scene, double load_s, MistakeList& mistakes, Diagnostics& report, Json& figures) {
  PassPlans plans;
  std::string no_time;
  const double budget_s = kCheckTiming_s / static_cast<double>(1 + scene.later_passes.size());
  try {
    const bool fine = mistakes.attempt([&] {
      do {
        add_pass(scene, budget_s, plans);
      } while (begin_next_pass(scene));
    });
    if (!fine) no_time = "-";
  } catch (const RunError& error) {
    no_time = error.what();
  }
  report.note("memory: " + megabytes(plans.memory.device_bytes) + " on the device, up to " +
              megabytes(plans.memory.process_bytes) + " in total, plus rendering");
  figures["device_bytes"] = plans.memory.device_bytes;
  figures["process_bytes"] = plans.memory.process_bytes;
  if (no_time == "-") return;
  if (!no_time.empty()) return report.warn("no time estimate: the engine cannot start: " + no_time);
  if (scene.motion.push) {
    report.note("time: not estimated: a push is as long as the bone makes it");
    return;
  }
  report.note(fmt::format("time: about {:.2g} s for the simulation ({} frames in {} windows timed on {})",
                          plans.time.simulate_s, plans.time.timed_frames, plans.time.windows, plans.device));
  figures["device"] = plans.device;
  figures["simulate_s"] = plans.time.simulate_s;
  report.note(picture_time(scene, load_s + plans.load_s, figures));
}

void warn_of_settings(const SimulationInput& scene, Diagnostics& report) {
  const auto still = [](const Motion& motion) {
    for (std::size_t k = 0; k < motion.poses.size(); ++k) {
      if (motion.poses[k].spin_rpm != 0) return false;
    }
    return true;
  };
  if (still(scene.motion) || std::ranges::any_of(scene.later_passes, still, &Pass::motion)) {
    report.warn("spindle speed is zero: forces are those of a non-rotating tool");
  }
  try {
    require_film_program(scene.scenario.render);
  } catch (const RunError& error) {
    report.warn(error.what());
  }
}

/// What --json prints of a scenario without mistakes.
Json json_of(const Scenario& scenario, const Diagnostics& report, const Json& figures) {
  return {{"program", "reamsim " REAMSIM_VERSION},
          {"scenario", scenario.name},
          {"ok", true},
          {"mistakes", Json::array()},
          {"warnings", report.warnings},
          {"listings", report.listings},
          {"notes", report.notes},
          {"estimate", figures},
          {"resolved", to_yaml(scenario)}};
}

struct CheckOptions {
  ScenarioOptions scenario;
  std::string picture;
  bool overwrite = false;
  bool json = false;
};

/// Throws InputError for a file that is no PNG, or that must not be replaced.
void require_picture_file(const CheckOptions& options, const Scenario& scenario) {
  if (options.picture.empty()) return;
  if (lower_extension(options.picture) != ".png") {
    throw InputError({options.picture, 0, 0}, "--picture", "the file does not end in .png", "use --picture NAME.png");
  }
  std::vector<std::string> inputs{scenario.file};
  for (const auto& [role, path] : input_files(scenario)) inputs.push_back(path);
  require_replaceable_file(options.picture, "--picture", options.overwrite, is_setup_picture, inputs);
}

void draw_setup(const CheckOptions& options, const SimulationInput& scene, const ContactForecast& contact,
                Diagnostics& report) {
  if (options.picture.empty()) return;
  const auto forced = removing_unfinished(options.picture);
  const std::string warning = write_setup_picture(options.picture, {.inputs = inputs_without_folder(scene),
                                                                    .contact = contact,
                                                                    .frame_s = scene.motion.frame_s(),
                                                                    .settings = scene.scenario.render});
  if (!warning.empty()) report.warn(warning);
  report.note("picture: " + options.picture);
}

/// What `check` says of a scenario.
struct Findings {
  SimulationInput scene;
  Diagnostics report;
  MistakeList mistakes;  ///< of the glenoid frame
  Json figures;
};

/// Loads the scenario and estimates its run. Warnings found before an error are printed.
Findings examine(const CheckOptions& options, const Scenario& scenario, const Stopwatch& watch,
                 const Console& console) {
  Findings out;
  Diagnostics found;
  const auto warnings_of_error = print_on_error(found, console);
  out.scene = load_scene(scenario, found, out.mistakes);
  SimulationInput& scene = out.scene;
  const double load_s = watch.seconds();
  const std::vector<ContactForecast> contacts = forecast_passes(scene);
  const ContactForecast contact = of_whole_run(contacts);
  scene.contact = contact_frames(contacts);
  warn_of_contact(scene, contacts, found);
  const std::optional<HolderClearance> clearance = find_clearance(scene);
  if (clearance) warn_of_clearance(*clearance, scene, found);
  warn_of_settings(scene, found);
  draw_setup(options, scene, contact, found);  // before a mistake of the pose ends the command: it shows there
  Diagnostics& report = out.report;
  report.warnings = found.warnings;
  note_cost(scene, report, out.figures);
  note_plans(scene, load_s, out.mistakes, report, out.figures);
  if (clearance) report.note(sentence_of(*clearance, scene));
  if (scene.bone.segmentation) report.note(sentence_of(*scene.bone.segmentation));
  report.listings = std::move(found.listings);
  report.notes.insert(report.notes.end(), found.notes.begin(), found.notes.end());
  return out;
}

void check_command(const CheckOptions& options, const Console& console) {
  const Scenario scenario = options.scenario.parse();
  require_picture_file(options, scenario);
  std::unique_ptr<cl::KernelCache> kernels;
  try {
    kernels = prepare_opencl(scenario.engine.device, console);
  } catch (const InputError&) {  // no folder for kernels: the time estimate warns that there is no device
  }
  const Stopwatch load_watch;
  const auto [scene, report, mistakes, figures] = examine(options, scenario, load_watch, console);
  // On a terminal, standard error would repeat them.
  if (isatty(STDOUT_FILENO) == 0 || console.quiet) {
    for (const std::string& warning : report.warnings) console.warn(warning);
  }
  if (options.json) {
    mistakes.throw_if_any();
    return print_json(json_of(scene.scenario, report, figures));
  }
  // As YAML comments, so that the output is a scenario.
  for (const std::string& warning : report.warnings) console.say("# warning: " + warning);
  for (const std::string& listing : report.listings) console.say("# " + listing);
  for (const std::string& note : report.notes) console.say("# " + note);
  mistakes.throw_if_any();
  console.say_lines(to_yaml(scene.scenario));
}

}  // namespace

void add_run_command(CLI::App& app, Console& console) {
  const auto [command, options] =
      add_command(app, "run", "Simulate a scenario and write forces, pictures, plots and grids", console, run_command);
  options->scenario.add_to(*command);
  add_output(*command, options->output, "Output folder (default: out/NAME)");
  command->add_flag("--overwrite", options->overwrite, "Replace an existing results folder once the run succeeds");
  command->add_flag("--resume", options->resume,
                    "Continue an interrupted run from its last checkpoint; without one, start at the first frame");
  command->add_flag("--draft", options->scenario.draft,
                    "A quick look: voxels twice as large, the first camera at the start and the end only, one plot, no "
                    "report, meshes or reamed.vti; --set takes precedence. Default folder: out/NAME-draft");
  auto* quiet = command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->add_flag("--verbose", console.verbose, "Print what each stage did")->excludes(quiet);
}

void add_check_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("check",
                                     "Validate a scenario, estimate time and memory, and print it with all defaults; "
                                     "write nothing but a picture on request");
  auto options = std::make_shared<CheckOptions>();
  options->scenario.add_to(*command);
  auto* picture = add_path_option(
      *command, "--picture", options->picture,
      "Draw bone, reamer and path as three views in this PNG file: at the start and at the greatest depth", "FILE.png");
  command->add_flag("--overwrite", options->overwrite, "Replace the picture")->needs(picture);
  command->add_flag("--json", options->json,
                    "Print one JSON document: mistakes, warnings, estimates, resolved scenario");
  command->callback([options, &console] {
    if (!options->json) return check_command(*options, console);
    run_with_json(console, [&](const Console& silent) { check_command(*options, silent); });
  });
}

}  // namespace reamsim
