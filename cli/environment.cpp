// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/environment.h"

#include <fcntl.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "cli/commands.h"
#include "cli/commit.h"
#include "cli/console.h"
#include "cli/library_versions.h"
#include "sim/base/error.h"
#include "sim/base/process.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

/// The libraries that the loader maps, 131 MB, and their initializers.
constexpr rlim_t kLeastAddressSpace = 256'000'000;

void write_text(const char* text) {
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text, std::strlen(text));
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // whose own memory is larger
/// Called before the initializers of libraries, some of which abort without memory. Only system calls work here.
void refuse_small_address_space(int, char**, char**) {
  rlimit limit{};
  const bool unlimited = getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY;
  if (unlimited || limit.rlim_cur >= kLeastAddressSpace) return;
  write_text(
      "reamsim: error: the address space is limited to less than 256 MB (ulimit -v); raise the limit: 2 GB suffice for "
      "small scenarios with pictures\n");
  _exit(1);
}

__attribute__((section(".preinit_array"), used)) void (*const kBeforeLibraries)(int, char**,
                                                                                char**) = refuse_small_address_space;
#endif

/// The message of end_with_reason(): a handler must not allocate.
char fatal_reason[512];

pid_t explained_process = 0;

void end_with_reason(int signal) {
  if (getpid() == explained_process) {
    write_text(fatal_reason);
    _exit(1);
  }
  std::signal(signal, SIG_DFL);  // a child that reads a file: this process says what happened
  raise(signal);
}

bool reader_has_left(int descriptor) {
  pollfd output{.fd = descriptor, .events = POLLOUT, .revents = 0};
  return poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

constexpr const char* kTuningVariable = "REAMSIM_ENGINE_TUNING";

/// Sets one member from "name=value"; false where the text is none of them.
bool set_tuning(EngineTuning& tuning, const std::string& text) {
  const std::string name = text.substr(0, text.find('='));
  const std::string value = name.size() < text.size() ? text.substr(name.size() + 1) : "";
  if (name == "kernel_shape" && from_name<KernelShape>(value)) {
    tuning.kernel_shape = *from_name<KernelShape>(value);
    return true;
  }
  for (const auto& [flag, member] : {std::pair{"culling", &tuning.culling}, std::pair{"windows", &tuning.windows}}) {
    if (name != flag || (value != "true" && value != "false")) continue;
    *member = value == "true";
    return true;
  }
  if (name != "work_group_size" || !is_whole_number(value)) return false;
  tuning.work_group_size = static_cast<int>(whole_number(value).value_or(0));
  return true;
}

/// The drivers are loaded when the program runs, so no build knows them. The version is printed wherever it can be.
std::string opencl_text() try {
  const Console console;
  const auto kernels = prepare_opencl("auto", console);
  std::string out;
  for (const cl::DeviceInfo& device : cl::list_devices()) {
    out += (out.empty() ? "" : "; ") + device.name + " (" + device.platform_name + ", driver " + device.driver + ")";
  }
  return out.empty() ? "no device" : printable(out);
} catch (const std::exception& error) {
  return "not available: " + printable(message_of(error));
}

std::string line(const cl::DeviceInfo& device, cl_device_id chosen) {
  std::string out = fmt::format("{} {}  [{}, driver {}, {}, {} compute units, {} MB, largest allocation {} MB]",
                                device.id == chosen ? "*" : " ", device.name, device.platform_name, device.driver,
                                device.gpu ? "GPU" : "CPU", device.compute_units,
                                device.global_memory_bytes / 1'000'000, device.max_allocation_bytes / 1'000'000);
  if (!device.missing.empty()) return out + "\n    not usable: missing " + device.missing;
  return out + fmt::format("\n    {} kernels, sums by {}{}", device.gpu ? "GPU" : "CPU",
                           device.int64_atomics ? "64-bit atomics" : "two atomics of 32 bits",
                           device.rounds_division ? "; results have the bytes of serial"
                                                  : "; division is not correctly rounded: forces may differ from "
                                                    "serial in the last digits");
}

/// The device that `auto` selects, and why; no device where none is usable.
struct Choice {
  cl_device_id id = nullptr;
  std::string name;
  std::string why;
};

Choice automatic_choice() {
  try {
    const cl::DeviceInfo device = cl::choose_device("auto");
    return {device.id, device.name,
            std::string("the first ") + (device.gpu ? "GPU" : "CPU") + "; GPUs are preferred to CPUs"};
  } catch (const RunError& error) {
    return {nullptr, "", error.what()};
  }
}

void devices_command(const Console& console) {
  const auto kernels = prepare_opencl("auto", console);
  const auto devices = cl::list_devices();
  if (devices.empty()) {
    for (const std::string& platform : cl::platforms_without_device()) console.say(platform);
    console.say("no OpenCL device found: install a driver (Debian: pocl-opencl-icd), or use --device serial (slow)");
    return;
  }
  const Choice choice = automatic_choice();
  for (const auto& device : devices) console.say_lines(line(device, choice.id));
  for (const std::string& platform : cl::platforms_without_device()) console.say(platform);
  console.say((choice.name.empty() ? "auto: " : "auto selects " + choice.name + ": ") + choice.why);
  console.say("serial is always available: the reference in plain C++ (slow)");
}

using Json = nlohmann::ordered_json;

Json json_of(const cl::DeviceInfo& device, const Choice& choice) {
  return {{"name", device.name},
          {"platform", device.platform_name},
          {"driver", device.driver},
          {"type", device.gpu ? "gpu" : "cpu"},
          {"compute_units", device.compute_units},
          {"memory_bytes", device.global_memory_bytes},
          {"largest_allocation_bytes", device.max_allocation_bytes},
          {"local_memory_bytes", device.local_memory_bytes},
          {"unified_memory", device.unified_memory},
          {"fp64", device.fp64},
          {"int64_atomics", device.int64_atomics},
          {"rounds_division", device.rounds_division},
          {"missing", device.missing},
          {"selected", device.id == choice.id}};
}

void print_devices_as_json(const Console& console) {
  const auto kernels = prepare_opencl("auto", console);
  const Choice choice = automatic_choice();
  Json devices = Json::array();
  for (const auto& device : cl::list_devices()) devices.push_back(json_of(device, choice));
  print_json({{"program", "reamsim " REAMSIM_VERSION},
              {"ok", true},
              {"mistakes", Json::array()},
              {"auto", choice.name.empty() ? Json() : Json(choice.name)},
              {"why", choice.why},
              {"devices", devices}});
}

}  // namespace

void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) == -1 && errno == EBADF) open("/dev/null", O_RDWR);
  }
}

void explain_fatal_signals() {
  const std::string limit = address_space_note();
  if (limit.empty()) return;
  const std::string line =
      "reamsim: error: a library ended the program; " + limit + ", which is the likely cause: raise the limit\n";
  std::strncpy(fatal_reason, line.c_str(), sizeof fatal_reason - 1);
  explained_process = getpid();
  for (const int signal : {SIGABRT, SIGTRAP, SIGSEGV, SIGBUS}) std::signal(signal, end_with_reason);
}

int flush_standard_output(int status) {
  const bool lost = std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
  if (!lost || status != 0 || reader_has_left(STDOUT_FILENO)) return status;
  write_text(
      "reamsim: error: standard output: cannot be written; is the disk full? Results in files are not affected\n");
  return 1;
}

EngineTuning tuning_of_environment() {
  EngineTuning tuning;
  const char* const given = std::getenv(kTuningVariable);
  std::istringstream words(given == nullptr ? "" : given);
  for (std::string word; words >> word;) {
    if (!set_tuning(tuning, word)) {
      throw InputError(
          {}, kTuningVariable, "found " + word,
          "expected kernel_shape=auto|cpu|gpu, culling=true|false, windows=true|false or work_group_size=N");
    }
  }
  return tuning;
}

std::unique_ptr<cl::KernelCache> prepare_opencl(const std::string& device, const Console& console) {
  if (device == "serial") return nullptr;
  auto cache = std::make_unique<cl::KernelCache>();
  if (console.verbose && !cache->note().empty()) console.say(cache->note());
  if (!address_space_note().empty()) {
    cl::list_devices();  // loads the drivers, whose compilers set handlers of their own
    explain_fatal_signals();
  }
  return cache;
}

std::string version_text() {
  const std::string commit = kCommit[0] == '\0' ? "" : std::string("commit ") + kCommit + ", ";
  std::vector<std::string> libraries;
  for (const auto& [name, version] : kLibraryVersions)
    libraries.push_back(fmt::format("{}{}{}", name, version.empty() ? "" : " ", version));
  return "reamsim " REAMSIM_VERSION "\n" + commit + std::string(kBuildType) + " build by " + std::string(kCompiler) +
         fmt::format("\nlibraries: {}\nOpenCL: ", fmt::join(libraries, ", ")) + opencl_text() +
         "\nLicensed under the Apache License, Version 2.0. Copyright the reamsim authors.";
}

void add_devices_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("devices", "List OpenCL devices and mark the one that `auto` selects");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print one JSON document");
  command->callback(
      [json, &console] { *json ? run_with_json(console, print_devices_as_json) : devices_command(console); });
}

}  // namespace reamsim
