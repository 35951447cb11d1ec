// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/console.h"
#include "sim/record/output_folder.h"
#include "sim/scenario/scenario.h"

namespace CLI {
class App;
}

namespace reamsim {

/// Each adds one command to `app`, which runs it while it parses the arguments. Commands throw InputError, RunError or
/// Interrupted; main() turns them into exit statuses (docs/architecture.md).
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
void add_cite_command(CLI::App& app);
/// It prints what the other commands of `app` say of themselves.
void add_help_command(CLI::App& app);

/// The arguments that `run` and `check` share.
struct ScenarioOptions {
  std::string file;
  std::vector<std::string> overrides;
  std::string device;
  std::string engine;

  void add_to(CLI::App& command);
  /// The scenario with `--set`, `--device` and `--engine` applied, and with the tuning of the environment variable
  /// REAMSIM_ENGINE_TUNING, which tests use (docs/engines.md). Throws InputError.
  [[nodiscard]] Scenario parse() const;
};

/// Finishes the output folder of a command, and prints its warning.
inline void finish(OutputFolder& folder, const Console& console, const std::function<void()>& remove_unfinished = {}) {
  if (const std::string warning = folder.finish(remove_unfinished); !warning.empty()) console.warn(warning);
}

/// For CLI11's check(): refuses the name "".
inline std::string refuse_empty(const std::string& name) {
  return name.empty() ? "empty name; give a file or folder" : "";
}

/// The option -o DIR of a command. A template, so that this header needs no CLI11.
template <class App>
auto* add_output(App& command, std::string& dir, const char* description) {
  return command.add_option("-o,--output", dir, description)->type_name("DIR")->check(refuse_empty);
}

}  // namespace reamsim
