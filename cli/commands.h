// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "cli/console.h"
#include "sim/record/output_folder.h"

namespace CLI {
class App;
}

namespace reamsim {

/// Each adds one command to `app`, which runs it while it parses. Commands throw InputError, RunError or Interrupted.
void add_run_command(CLI::App& app, Console& console);
void add_check_command(CLI::App& app, Console& console);
void add_render_command(CLI::App& app, Console& console);
void add_compare_command(CLI::App& app, Console& console);
void add_reforce_command(CLI::App& app, Console& console);
void add_fit_command(CLI::App& app, Console& console);
void add_import_command(CLI::App& app, Console& console);
void add_init_command(CLI::App& app, Console& console);
void add_preview_command(CLI::App& app, Console& console);
void add_bench_command(CLI::App& app, Console& console);
void add_verify_command(CLI::App& app, Console& console);
void add_devices_command(CLI::App& app, Console& console);
void add_sweep_command(CLI::App& app, Console& console);
void add_uq_command(CLI::App& app, Console& console);
void add_validate_command(CLI::App& app, Console& console);
void add_cache_command(CLI::App& app, Console& console);
void add_cite_command(CLI::App& app);
/// It prints what the other commands of `app` say of themselves.
void add_help_command(CLI::App& app);

/// Finishes the output folder of a command, and prints its warning.
inline void finish(OutputFolder& folder, const Console& console) {
  if (const std::string warning = folder.finish(); !warning.empty()) console.warn(warning);
}

/// For CLI11's check(): refuses the name "".
inline std::string refuse_empty(const std::string& name) {
  return name.empty() ? "empty name; give a file or folder" : "";
}

/// The option -o of a command. A template, so that this header needs no CLI11.
template <class App>
auto* add_output(App& command, std::string& path, const char* description, const char* type = "DIR") {
  return command.add_option("-o,--output", path, description)->type_name(type)->check(refuse_empty);
}

}  // namespace reamsim
