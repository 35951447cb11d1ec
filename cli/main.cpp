// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/environment.h"
#include "cli/stop.h"
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
  for (const auto add :
       {reamsim::add_run_command, reamsim::add_check_command, reamsim::add_render_command, reamsim::add_compare_command,
        reamsim::add_reforce_command, reamsim::add_fit_command, reamsim::add_sweep_command, reamsim::add_uq_command,
        reamsim::add_import_command, reamsim::add_init_command, reamsim::add_preview_command}) {
    add(app, console);
  }
#ifdef REAMSIM_VERIFICATION
  reamsim::add_bench_command(app, console);
  reamsim::add_verify_command(app, console);
#endif
  reamsim::add_devices_command(app, console);
  reamsim::add_cite_command(app);
  reamsim::add_help_command(app);
}

/// Parses the arguments, which calls the command.
int run(int argc, char** argv) {
  CLI::App app{std::string(reamsim::kDescription), "reamsim"};
  reamsim::Console console;
  add_commands(app, console);
  if (argc == 1) {  // as git and others do: help for a person, a status for a script whose command is missing
    std::fputs(reamsim::help_of({"", &app}).c_str(), stderr);
    return kWrongInput;
  }
  // CLI11 would only report a missing command.
  const auto named = [&](const CLI::App* command) { return command->get_name() == argv[1]; };
  const bool known = !app.get_subcommands(named).empty();
  if (argv[1][0] != '-' && !known) {
    const std::string found = std::string(argv[1]) + ": unknown command; expected " + reamsim::command_names(app);
    return complain(reamsim::printable(found).c_str(), kWrongInput);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    const std::string where = known ? "; see reamsim " + std::string(argv[1]) + " --help" : "; see reamsim --help";
    return complain((reamsim::printable(error.what()) + where).c_str(), kWrongInput);
  }
  return 0;
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

int main(int argc, char** argv) {
  reamsim::open_standard_streams();
  reamsim::explain_fatal_signals();
  // Pins PoCL's worker threads to their cores, for their caches. Must be set before OpenCL is loaded.
  setenv("POCL_AFFINITY", "1", 0);
  int status = 0;
  try {
    reamsim::start_reader_server();  // before there are threads
    std::set_terminate(end_with_message);
    reamsim::install_stop_handler();
    status = run(argc, argv);
  } catch (...) {
    status = complain_of_error();
  }
  return reamsim::end_with(reamsim::flush_standard_output(status));
}
