// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "cli/console.h"
#include "sim/record/output_folder.h"

namespace CLI {
class App;
}

namespace reamsim {

/// Adds one command to `app`, which runs it while it parses. Commands throw InputError, RunError or Interrupted.
using AddCommand = void(CLI::App& app, Console& console);
AddCommand add_run_command, add_check_command, add_render_command, add_compare_command, add_reforce_command,
    add_fit_command, add_import_command, add_init_command, add_preview_command, add_bench_command, add_verify_command,
    add_devices_command, add_sweep_command, add_uq_command, add_validate_command, add_cache_command;
void add_cite_command(CLI::App& app);
/// It prints what the other commands of `app` say of themselves.
void add_help_command(CLI::App& app);

/// Adds a command that calls `call` with its options, and returns both. A template, so that this header needs no CLI11.
template <class App, class Options>
auto add_command(App& app, const char* name, const char* description, Console& console,
                 void (*call)(Options, const Console&)) {
  auto options = std::make_shared<std::remove_cvref_t<Options>>();
  auto* command = app.add_subcommand(name, description);
  command->callback([options, call, &console] { call(*options, console); });
  return std::pair(command, options);
}

/// Finishes the output folder of a command, and prints its warning.
inline void finish(OutputFolder& folder, const Console& console) {
  if (const std::string warning = folder.finish(); !warning.empty()) console.warn(warning);
}

/// For CLI11's check(): refuses the name "".
inline std::string refuse_empty(const std::string& name) {
  return name.empty() ? "empty name; give a file or folder" : "";
}

/// An option of a command for a file or folder, and -o. Templates, so that this header needs no CLI11.
template <class App>
auto* add_path_option(App& command, const char* name, std::string& path, const char* description, const char* type) {
  return command.add_option(name, path, description)->type_name(type)->check(refuse_empty);
}
template <class App>
auto* add_output(App& command, std::string& path, const char* description, const char* type = "DIR") {
  return add_path_option(command, "-o,--output", path, description, type);
}

}  // namespace reamsim
