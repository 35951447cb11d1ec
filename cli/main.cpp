#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "cli/commands.h"
#include "cli/environment.h"
#include "cli/stop.h"
#include "sim/base/error.h"

namespace {

constexpr int kFailed = 1, kWrongInput = 2;

int complain(const std::string& message, int status) {
  std::fprintf(stderr, "reamsim: error: %s\n", message.c_str());
  return status;
}

/// Parses the arguments, which calls the command.
int run(int argc, char** argv) {
  CLI::App app{
      "reamsim simulates glenoid reaming: it turns a scenario into cutting forces, pictures and an OpenVDB grid."};
  app.set_version_flag("--version", "reamsim " REAMSIM_VERSION
                                    "\nLicensed under the Apache License, Version 2.0. Copyright the reamsim authors.");
  app.require_subcommand(1);
  reamsim::Console console;
  reamsim::add_run_command(app, console);
  reamsim::add_check_command(app, console);
  reamsim::add_render_command(app, console);
  reamsim::add_compare_command(app, console);
  reamsim::add_import_command(app, console);
#ifdef REAMSIM_VERIFICATION
  reamsim::add_bench_command(app, console);
  reamsim::add_verify_command(app, console);
#endif
  reamsim::add_devices_command(app, console);
  // CLI11 would only report a missing command.
  const auto named = [&](const CLI::App* command) { return argc > 1 && command->get_name() == argv[1]; };
  if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(named).empty()) {
    const std::string found =
        std::string(argv[1]) +
        ": unknown command; expected run, check, render, compare, import, bench, verify or devices";
    return complain(found, kWrongInput);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return complain(std::string(error.what()) + "; see reamsim --help", kWrongInput);
  }
  return 0;
}

/// As run(), with a message and a status for every error.
int run_and_report(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const reamsim::InputError& error) {
    for (const reamsim::Mistake& mistake : error.mistakes()) complain(mistake.line(), kWrongInput);
    return kWrongInput;
  } catch (const reamsim::Suspended& error) {
    return complain(error.what(), reamsim::kSuspendedStatus);
  } catch (const reamsim::Interrupted& error) {
    return complain(error.what(), reamsim::kInterruptedStatus);
  } catch (const std::exception& error) {
    return complain(reamsim::message_of(error), kFailed);
  }
}

}  // namespace

int main(int argc, char** argv) {
  reamsim::open_standard_streams();
  reamsim::explain_fatal_signals();
  // Pins PoCL's worker threads to their cores, for their caches. Must be set before OpenCL is loaded.
  setenv("POCL_AFFINITY", "1", 0);
  reamsim::install_stop_handler();
  return reamsim::end_with(reamsim::flush_standard_output(run_and_report(argc, argv)));
}
