// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// reamsim validate: studies whose results others have measured.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/lab.h"
#include "cli/sweep.h"

namespace reamsim {

namespace {

struct ValidateOptions {
  std::vector<std::string> studies;  ///< none: all that are shipped
  std::string output = "out/validation";
  int jobs = 1;
};

std::vector<std::string> shipped_validations() {
  std::vector<std::string> names = shipped_names(ShippedKind::study);
  std::erase_if(names, [](const std::string& name) { return !name.starts_with("validation/"); });
  return names;
}

/// "drilling" may stand for "validation/drilling".
std::string file_of_validation(const std::string& name) {
  const std::vector<std::string> shipped = shipped_validations();
  const bool is_short = std::ranges::find(shipped, "validation/" + name) != shipped.end();
  return shipped_or_path(is_short ? "validation/" + name : name, ShippedKind::study);
}

void validate(const std::string& file, const ValidateOptions& options, const Console& console) {
  const std::string published = std::filesystem::path(file).replace_extension(".csv").string();
  const Study study = read_study(file);
  const nlohmann::ordered_json job{{"name", study.name}, {"parameters", make_plan(study).columns}};
  call_lab("published", {published}, job);  // its mistakes before minutes of simulation
  const std::string dir = options.output + "/" + study.name;
  simulate_study({.file = file, .output = dir, .jobs = options.jobs, .shows_table = false}, console);
  say_answer(call_lab("validate", {published, dir}, job), console);
  console.say("comparison: " + dir + "/" + study.name + ".csv, .png, .svg, .pdf, .py");
}

}  // namespace

void add_validate_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("validate", "Compare simulations with published measurements");
  auto options = std::make_shared<ValidateOptions>();
  command->add_option("STUDY", options->studies,
                      "Studies with published numbers in a CSV beside them, or names of shipped ones (default: all of "
                      "these)");
  add_output(*command, options->output, "Folder of the studies' folders (default: out/validation)");
  add_jobs(*command, options->jobs);
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->callback([options, &console] {
    std::vector<std::string> files;
    for (const std::string& name : options->studies.empty() ? shipped_validations() : options->studies)
      files.push_back(file_of_validation(name));
    for (const std::string& file : files) validate(file, *options, console);
  });
}

}  // namespace reamsim
