// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>
#include <string_view>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/outputs.h"
#include "render/render.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/record/output_folder.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

struct RenderOptions {
  std::string dir;
  std::vector<std::string> cameras;
  std::vector<std::string> only;
  std::vector<std::string> overrides;
  std::string context;
  std::string film;
  std::optional<int> film_rate_hz;
  std::optional<int> turntable_pictures;
  std::optional<int> width_px;
  std::optional<int> height_px;

  [[nodiscard]] bool wants(const char* kind) const {
    return only.empty() || std::ranges::find(only, kind) != only.end();
  }
};

/// A turntable without a number has steps of ten degrees.
constexpr int kTurntablePictures = 36;

/// The settings of the run with those of the command line, except its cameras.
ResultSettings settings_of(const RenderOptions& options, const std::string& own_cameras) {
  std::vector<std::string> overrides = options.overrides;
  for (const std::string& override : overrides) {
    if (override.starts_with("render.")) continue;
    throw InputError(
        {}, "--set", "found '" + override + "'",
        "expected render.KEY=VALUE: this command only renders; to change anything else, run the scenario again");
  }
  const auto set = [&](const std::string& key, const std::string& value) {
    if (!value.empty()) overrides.push_back("render." + key + "=" + value);
  };
  const auto text = [](const std::optional<int>& number) { return number ? std::to_string(*number) : ""; };
  set("width_px", text(options.width_px));
  set("height_px", text(options.height_px));
  set("frame_height_px", text(options.height_px));
  set("context", options.context);
  set("film", options.film);
  set("film_rate_hz", text(options.film_rate_hz));
  set("turntable_pictures", text(options.turntable_pictures));
  set("user_cameras", own_cameras);
  return parse_result_settings(options.dir + "/scenario.yaml", overrides);
}

/// The cameras that an option describes in braces. Its mistakes name the option instead of the key that it sets.
std::vector<UserCamera> described_cameras(const RenderOptions& options, const std::string& described) {
  constexpr std::string_view kPlace = "--set render.user_cameras=", kKey = "render.user_cameras.0.";
  try {
    return settings_of(options, "[" + described + "]").render.user_cameras;
  } catch (const InputError& error) {
    std::vector<Mistake> mistakes = error.mistakes();
    for (Mistake& mistake : mistakes) {
      if (!mistake.where.file.starts_with(kPlace)) continue;
      mistake.where = {"--camera " + shown_path(described), 0, 0};
      if (mistake.key.starts_with(kKey)) mistake.key.erase(0, kKey.size());
    }
    throw InputError(std::move(mistakes));
  }
}

/// Adds the cameras that an option names or describes; `known` are those of render.user_cameras.
void add_cameras(const RenderOptions& options, const std::string& option, const std::vector<UserCamera>& known,
                 RenderSettings& settings) {
  const auto own = std::ranges::find(known, option, &UserCamera::name);
  if (option.starts_with('{')) {
    std::ranges::move(described_cameras(options, option), std::back_inserter(settings.user_cameras));
  } else if (own != known.end()) {
    settings.user_cameras.push_back(*own);
  } else if (const auto view = from_name<CameraView>(option)) {
    settings.cameras.push_back(*view);
  } else {
    std::string names = "glenoid, oblique, section, overview";
    for (const UserCamera& camera : known) names += ", " + camera.name;
    throw InputError({}, "--camera", "found '" + option + "'",
                     "expected " + names + ", or a camera in braces: '{name: N, position_mm: [x, y, z]}'");
  }
}

/// Keeps the cameras of the run that the options name, and adds those that they describe.
void choose_cameras(const RenderOptions& options, RenderSettings& settings) {
  const std::vector<UserCamera> known = std::move(settings.user_cameras);
  settings.cameras.clear();
  settings.user_cameras.clear();
  for (const std::string& option : options.cameras) add_cameras(options, option, known, settings);
  std::set<std::string> names;
  for (const std::string& name : camera_names(settings)) {
    if (!names.insert(name).second)
      throw InputError({}, "--camera", "found " + name + " twice", "give each camera once");
  }
}

/// Throws InputError for an option that has no effect beside those of `--only`, and for a film's rate without a film.
void require_effects(const RenderOptions& options, const RenderSettings& settings) {
  const auto require = [&](bool given, const char* option, const std::vector<const char*>& kinds) {
    if (!given || std::ranges::any_of(kinds, [&](const char* kind) { return options.wants(kind); })) return;
    throw InputError({}, option, "has no effect on what --only names", std::string("add --only ") + kinds.front());
  };
  const std::vector<const char*> pictures{"pictures", "before_after", "contact_sheet", "turntable", "film"};
  require(!options.cameras.empty(), "--camera", pictures);
  require(options.width_px.has_value(), "--width", pictures);
  require(options.height_px.has_value(), "--height", pictures);
  require(!options.context.empty(), "--context", pictures);
  require(!options.film.empty(), "--film", {"film", "turntable"});
  require(options.turntable_pictures.has_value(), "--turntable", {"turntable"});
  if (options.turntable_pictures == 0 && !options.only.empty() && options.wants("turntable")) {
    throw InputError({}, "--turntable", "found 0", "give the number of pictures of --only turntable, or leave it out");
  }
  if (options.film_rate_hz && settings.film == FilmFormat::none) {
    throw InputError({}, "--film-rate", "has no effect: no film is made", "add --film");
  }
}

/// Throws InputError for a finished run of a study that keeps nothing that pictures are made from.
void require_kept(const std::string& dir) {
  const std::optional<Manifest> manifest = read_manifest(dir);
  if (!manifest || !manifest->complete) return;
  if (manifest->files.contains("reamed.vdb") && std::filesystem::exists(dir + "/snapshots")) return;
  refuse_file(dir, "holds no grid and snapshots, from which pictures are made",
              "add `keep: [pictures]` to the study of this run, and run the study again");
}

/// Throws InputError where `--only` names what a run with a checkpoint only cannot give.
void require_finished(const RenderOptions& options) {
  if (!is_unfinished(options.dir)) return;
  for (const char* kind : {"meshes", "report"}) {
    if (options.only.empty() || !options.wants(kind)) continue;
    throw InputError({options.dir, 0, 0}, std::string("--only ") + kind, "the run is not finished",
                     "continue it with `reamsim run SCENARIO --resume`");
  }
}

/// Keeps what `--only` names. A film, turntable or report that it names is made even if the run had none.
void choose_kinds(const RenderOptions& options, PictureOptions& pictures) {
  if (options.only.empty()) return;
  RenderSettings& settings = pictures.settings;
  settings.report = options.wants("report");
  pictures.stills = options.wants("pictures");
  settings.before_after = options.wants("before_after");
  settings.contact_sheet = options.wants("contact_sheet");
  if (!options.wants("turntable")) {
    settings.turntable_pictures = 0;
  } else if (settings.turntable_pictures == 0) {
    settings.turntable_pictures = kTurntablePictures;
  }
  pictures.film = options.wants("film");
  const bool film_of_turntable = options.wants("turntable") && !options.film.empty();
  if (!pictures.film && !film_of_turntable) settings.film = FilmFormat::none;
  if (pictures.film && settings.film == FilmFormat::none) settings.film = FilmFormat::mp4;
}

/// Shorter films are refused unless the user sets their frame rate: a run without a film keeps eight or eleven states.
constexpr double kShortestFilm_s = 2;

/// Throws InputError for a film that would show only a few states, and says what would give more.
void require_states_for_film(const RenderOptions& options, const PictureOptions& pictures, std::size_t states) {
  const RenderSettings& settings = pictures.settings;
  if (!pictures.film || settings.film == FilmFormat::none || options.film_rate_hz) return;
  const double film_s = static_cast<double>(states) / settings.film_rate_hz;
  if (film_s >= kShortestFilm_s) return;
  const std::string rate = std::to_string(std::max(1, static_cast<int>(static_cast<double>(states) / kShortestFilm_s)));
  refuse_file(
      options.dir + "/snapshots",
      "the run kept " + std::to_string(states) + " states: a film of them would last " + fixed_text(film_s, 2) + " s",
      "run the scenario again with --set render.film=" + name_of(settings.film) +
          ", which keeps up to 150 states, or show these slowly with --film-rate " + rate);
}

/// Checks cameras, and states and program of a film, before the first file is written. Throws InputError, RunError.
void require_drawable(const RenderOptions& options, const PictureOptions& pictures, const RunData& run) {
  require_states_for_film(options, pictures, run.inputs().frames.size());
  const RunView view(run, pictures.settings);
  if (count_pictures(pictures, view.frames(), run.contact()) == 0) return;
  static_cast<void>(shots_of(view, pictures));
  PictureOptions own = pictures;
  if (!own.film && own.settings.turntable_pictures == 0) own.settings.film = FilmFormat::none;
  require_film_program(own.settings);
}

/// What was made, and where it is.
std::string where_to_look(const RenderOptions& options, bool has_report) {
  if (!options.only.empty()) return fmt::format("{}: {}", fmt::join(options.only, ", "), options.dir);
  return has_report ? "report: " + options.dir + "/report.html" : "pictures and plots: " + options.dir;
}

void render_command(const RenderOptions& options, const Console& console) {
  if (!std::filesystem::is_directory(options.dir))
    refuse_file(options.dir, "folder not found", "expected the results folder of a finished run");
  require_kept(options.dir);
  const ResultSettings settings = settings_of(options, "");
  PictureOptions pictures{.settings = settings.render,
                          .camera_without_suffix = name_of(settings.render.cameras.front())};
  if (!options.cameras.empty()) choose_cameras(options, pictures.settings);
  choose_kinds(options, pictures);
  require_effects(options, pictures.settings);
  require_finished(options);
  pictures.settings.enabled = true;
  const RunData run = open_run(options.dir);
  require_drawable(options, pictures, run);
  Outputs outputs(console, run,
                  {.pictures = pictures,
                   .plots = options.wants("plots"),
                   .depth_map = options.wants("plots"),
                   .torque_spectrum = settings.tool_spin == ToolSpin::resolved,
                   .meshes = options.wants("meshes") && (settings.output.meshes || !options.only.empty()),
                   .report_cameras = settings.render.cameras,
                   .finished = !is_unfinished(options.dir)});
  ResultUpdate update(options.dir, ResultKind::run);
  Diagnostics report;
  const auto warnings_of_error = print_on_error(report, console);
  outputs.make(report);
  outputs.make_report();
  update.finish();
  console.print(report);
  console.say(where_to_look(options, pictures.settings.report && !is_unfinished(options.dir)));
}

}  // namespace

void add_render_command(CLI::App& app, Console& console) {
  const auto [command, options] =
      add_command(app, "render", "Re-render a finished run without simulating", console, render_command);
  command->add_option("DIR", options->dir, "Results folder of a finished run")->required();
  command
      ->add_option("--camera", options->cameras,
                   "glenoid, oblique, section, overview, a camera of render.user_cameras, or a camera in braces with "
                   "the same keys: '{name: N, position_mm: [x, y, z]}'; repeatable")
      ->expected(1)
      ->take_all();
  command->add_flag("--film{mp4}", options->film,
                    "Also render a film: mp4 (default), --film=webp or --film=apng; needs ffmpeg");
  command->add_option("--film-rate", options->film_rate_hz, "Frame rate of the film, pictures per second");
  command->add_option("--turntable", options->turntable_pictures, "Also render N turntable images");
  command
      ->add_option("--only", options->only,
                   "Render only this: pictures, before_after, contact_sheet, turntable, film, plots, meshes or report; "
                   "repeatable")
      ->expected(1)
      ->take_all()
      ->check(CLI::IsMember(
          {"pictures", "before_after", "contact_sheet", "turntable", "film", "plots", "meshes", "report"}));
  add_overrides(*command, options->overrides, "Override a render setting, for example render.background=transparent");
  command->add_option("--width", options->width_px, "Width of the pictures in pixels");
  command->add_option("--height", options->height_px, "Height of the pictures in pixels");
  command->add_option("--context", options->context, "OpenGL context")->type_name("auto|osmesa|egl");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
}

}  // namespace reamsim
