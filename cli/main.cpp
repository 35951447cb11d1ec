#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

#include "cli/commands.h"
#include "sim/base/error.h"

namespace {

constexpr int kFailed = 1, kWrongInput = 2, kInterrupted = 130;

int complain(const char* message, int status) {
  std::fprintf(stderr, "reamsim: error: %s\n", message);
  return status;
}

/// Parses the arguments, which runs the command.
int run(int argc, char** argv) {
  CLI::App app{"reamsim reams a bone on a computer: a scenario in; pictures, force plots and a VDB out."};
  app.set_version_flag("--version", "reamsim " REAMSIM_VERSION);
  app.require_subcommand(1);
  reamsim::Console console;
  reamsim::add_run_command(app, console);
  reamsim::add_check_command(app, console);
  reamsim::add_render_command(app, console);
  reamsim::add_compare_command(app, console);
  reamsim::add_import_command(app, console);
  reamsim::add_bench_command(app, console);
  reamsim::add_verify_command(app, console);
  reamsim::add_devices_command(app, console);
  // CLI11 would only say that a command is missing.
  const auto named = [&](const CLI::App* command) { return argc > 1 && command->get_name() == argv[1]; };
  if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(named).empty()) {
    const std::string found =
        std::string(argv[1]) +
        ": no such command; expected run, check, render, compare, import, bench, verify or devices";
    return complain(found.c_str(), kWrongInput);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    const std::string hint = std::string(error.what()) + "; see reamsim --help";
    return complain(hint.c_str(), kWrongInput);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  // PoCL's worker threads keep their caches only when they stay on their cores; must be set before OpenCL loads.
  setenv("POCL_AFFINITY", "1", 0);
  reamsim::install_stop_handler();
  try {
    return run(argc, argv);
  } catch (const reamsim::InputError& error) {
    return complain(error.what(), kWrongInput);
  } catch (const reamsim::RunError& error) {
    return complain(error.what(), kFailed);
  } catch (const reamsim::Interrupted&) {
    return complain("interrupted", kInterrupted);
  } catch (const std::bad_alloc&) {
    return complain("out of memory; use a larger bone.voxel_mm or a smaller crop", kFailed);
  } catch (const std::exception&) {
    return complain("internal error; please report it with the scenario", kFailed);
  }
}
