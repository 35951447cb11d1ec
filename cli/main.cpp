// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <malloc.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <optional>
#include <string>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/environment.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/isolation/read_in_child.h"

namespace {

constexpr int kFailed = 1, kWrongInput = 2;

/// `message`: printable(). No std::string: memory may be exhausted.
int complain(const char* message, int status) {
  const char* const label = reamsim::has_colors() ? "\033[31mreamsim: error:\033[0m" : "reamsim: error:";
  std::fprintf(stderr, "%s %s\n", label, message);
  return status;
}

/// For std::terminate(): functions of libraries that must not throw, and find no memory. Results stay.
[[noreturn]] void end_with_message() {
  complain("out of memory, or a program error: use a larger bone.voxel_mm or a smaller crop, or report it", kFailed);
  reamsim::stop_reader_server();
  _exit(kFailed);
}

void add_commands(CLI::App& app, reamsim::Console& console) {
  app.require_subcommand(1);
  reamsim::set_help(app);
  app.set_version_flag("-V,--version", reamsim::version_text, "Print version, commit, build and libraries");
  for (const auto add : {reamsim::add_run_command, reamsim::add_check_command, reamsim::add_render_command,
                         reamsim::add_compare_command, reamsim::add_reforce_command, reamsim::add_fit_command,
                         reamsim::add_sweep_command, reamsim::add_uq_command, reamsim::add_validate_command,
                         reamsim::add_import_command, reamsim::add_init_command, reamsim::add_preview_command,
#ifdef REAMSIM_VERIFICATION
                         reamsim::add_bench_command, reamsim::add_verify_command,
#endif
                         reamsim::add_devices_command, reamsim::add_cache_command}) {
    add(app, console);
  }
  reamsim::add_cite_command(app);
  reamsim::add_help_command(app);
}

bool has_command(const CLI::App& app, const std::string& name) {
  return !app.get_subcommands([&](const CLI::App* command) { return command->get_name() == name; }).empty();
}

/// The exit status of arguments without a known command, of which CLI11 would only report that it is missing.
std::optional<int> refuse_command(const CLI::App& app, int argc, char** argv) {
  if (argc == 1) {  // as git and others do: help for a person, a status for a script whose command is missing
    std::fputs(reamsim::help_of({"", &app}).c_str(), stderr);
    return kWrongInput;
  }
  if (argv[1][0] == '-' || has_command(app, argv[1])) return std::nullopt;
  const std::string found = std::string(argv[1]) + ": unknown command; expected " + reamsim::command_names(app);
  return complain(reamsim::printable(found).c_str(), kWrongInput);
}

/// Prints what --help or --version ask for, or the mistake. Returns the exit status.
int end_parsing(const CLI::App& app, const CLI::ParseError& error, const std::string& command) {
  if (error.get_exit_code() == 0) return app.exit(error);
  const std::string where = has_command(app, command) ? "; see reamsim " + command + " --help" : "; see reamsim --help";
  return complain((reamsim::printable(error.what()) + where).c_str(), kWrongInput);
}

/// Prints the error that is being handled, also where there is no memory for its message. Returns its exit status.
int complain_of_error() try {
  try {
    throw;
  } catch (const reamsim::InputError& error) {
    for (const reamsim::Mistake& mistake : error.mistakes())
      complain(reamsim::printable(mistake.line()).c_str(), kWrongInput);
    return kWrongInput;
  } catch (const reamsim::Suspended& error) {
    return complain(reamsim::printable(error.what()).c_str(), reamsim::kSuspendedStatus);
  } catch (const reamsim::Interrupted& error) {
    return complain(reamsim::printable(error.what()).c_str(), reamsim::kInterruptedStatus);
  } catch (const std::exception& error) {
    return complain(reamsim::printable(reamsim::message_of(error)).c_str(), kFailed);
  }
} catch (const std::bad_alloc&) {
  return complain("out of memory; use a larger bone.voxel_mm or a smaller crop", kFailed);
}

}  // namespace

/// Freed blocks of this size or more, and free memory of this size at the top of a heap, return to the system. glibc
/// would raise the size of blocks to 32 MB: default.yaml peaks at 556 MB then, at 514 MB with this one. glibc's 128 KiB
/// at the top cost default.yaml 0.2 s of page faults.
constexpr int kReturnedBytes = 4 << 20;

int main(int argc, char** argv) {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, kReturnedBytes);
  mallopt(M_TRIM_THRESHOLD, kReturnedBytes);
#endif
  reamsim::open_standard_streams();
  reamsim::explain_fatal_signals();
  // Pins PoCL's worker threads to their cores, for their caches. Must be set before OpenCL is loaded.
  setenv("POCL_AFFINITY", "1", 0);
  int status = 0;
  try {
    reamsim::start_reader_server();  // before there are threads
    std::set_terminate(end_with_message);
    reamsim::install_stop_handler();
    CLI::App app{std::string(reamsim::kDescription), "reamsim"};
    reamsim::Console console;
    add_commands(app, console);
    if (const auto refused = refuse_command(app, argc, argv)) return reamsim::end_with(*refused);
    try {
      app.parse(argc, argv);  // calls the command
    } catch (const CLI::ParseError& error) {
      status = end_parsing(app, error, argv[1]);
    }
  } catch (...) {
    status = complain_of_error();
  }
  return reamsim::end_with(reamsim::flush_standard_output(status));
}
