// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

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

constexpr const char* kFolder = "validation/";

/// `options`: of the command; its output is the folder of the studies' folders.
void validate(const std::string& file, SweepOptions options, const Console& console) {
  const std::string published = std::filesystem::path(file).replace_extension(".csv").string();
  const Study study = read_study(file);
  const nlohmann::ordered_json job{{"parameters", make_plan(study).columns}};
  call_lab("validate", {published}, job);  // mistakes before minutes of simulation
  const std::string dir = options.output + "/" + study.name;
  options.file = file;
  options.output = dir;
  simulate_study(options, console);
  say_answer(call_lab("validate", {published, dir}, job), console);
  console.say("comparison: " + dir + "/comparison.csv, .png, .svg, .pdf, .py");
}

}  // namespace

void add_validate_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("validate", "Compare simulations with published measurements");
  auto studies = std::make_shared<std::vector<std::string>>();
  auto options = std::make_shared<SweepOptions>();
  options->output = "out/validation";
  options->shows_table = false;
  command->add_option("STUDY", *studies,
                      "Studies with a CSV of published numbers, or names of shipped ones (default: all)");
  add_output(*command, options->output, "Folder of the studies' folders (default: out/validation)");
  add_jobs(*command, options->jobs);
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->callback([studies, options, &console] {
    std::vector<std::string> shipped = shipped_names(ShippedKind::study);
    std::erase_if(shipped, [](const std::string& name) { return !name.starts_with(kFolder); });
    if (studies->empty()) *studies = shipped;
    for (std::string& name : *studies) {  // "drilling" may stand for "validation/drilling"
      if (std::ranges::count(shipped, kFolder + name) > 0) name.insert(0, kFolder);
      name = shipped_or_path(name, ShippedKind::study);
    }
    for (const std::string& file : *studies) validate(file, *options, console);
  });
}

}  // namespace reamsim
