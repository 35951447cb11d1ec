// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A library for LD_PRELOAD, which makes a call fail in the program that it is loaded into, not in its children.
//   REAMSIM_FAULT         write, rename or allocation
//   REAMSIM_FAULT_AT      the number of the call that fails, from 1; 0: calls are only counted
//   REAMSIM_FAULT_ERROR   its errno; ENOSPC without it
//   REAMSIM_FAULT_LASTS   1: later calls fail as well
//   REAMSIM_FAULT_BYTES   smaller allocations are neither counted nor fail
//   REAMSIM_FAULT_DIR     writes and renames below this folder only
//   REAMSIM_FAULT_REPORT  a file for "count N" and "fault CALL PATH"
//   REAMSIM_FAULT_TRACE   1: the report also has the stack of the fault
//   REAMSIM_NO_EXCHANGE   1: renameat2() has no flags
// Calls are counted from main() to its end.
#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "faults.h"

namespace reamsim::test {

namespace {

/// Libraries that end the program, or are undefined, where memory is exhausted, and the loader.
constexpr std::array kFragile{"libLLVM",    "libclang", "libpocl", "libOpenCL",      "libOSMesa",
                              "libgallium", "libEGL",   "libGL",   "ld-linux-x86-64"};

struct Plan {
  FaultKind kind = FaultKind::none;
  long at = 0;
  int error = ENOSPC;
  bool lasts = false;
  std::size_t bytes = 0;
  bool trace = false;
  bool no_exchange = false;
  std::array<char, PATH_MAX> dir{};
  std::array<char, PATH_MAX> report{};
};

Plan plan;
std::atomic<bool> counting = false;
std::atomic<long> calls = 0;
std::atomic<bool> struck = false;
thread_local bool inside = false;

const char* taken(const char* name) {
  const char* value = getenv(name);
  return value == nullptr ? "" : value;
}

template <std::size_t N>
void copy(std::array<char, N>& to, const char* text) {
  std::snprintf(to.data(), N, "%s", text);
}

/// Children inherit neither the plan nor the library.
__attribute__((constructor)) void read_plan() {
  const char* kind = taken("REAMSIM_FAULT");
  if (std::strcmp(kind, "write") == 0) plan.kind = FaultKind::write;
  if (std::strcmp(kind, "rename") == 0) plan.kind = FaultKind::rename;
  if (std::strcmp(kind, "allocation") == 0) plan.kind = FaultKind::allocation;
  plan.at = std::atol(taken("REAMSIM_FAULT_AT"));
  if (const int error = std::atoi(taken("REAMSIM_FAULT_ERROR")); error != 0) plan.error = error;
  plan.lasts = *taken("REAMSIM_FAULT_LASTS") == '1';
  plan.bytes = static_cast<std::size_t>(std::atol(taken("REAMSIM_FAULT_BYTES")));
  plan.trace = *taken("REAMSIM_FAULT_TRACE") == '1';
  plan.no_exchange = *taken("REAMSIM_NO_EXCHANGE") == '1';
  copy(plan.dir, taken("REAMSIM_FAULT_DIR"));
  copy(plan.report, taken("REAMSIM_FAULT_REPORT"));
  for (const char* name : {"REAMSIM_FAULT", "LD_PRELOAD"}) unsetenv(name);
  std::array<void*, 1> frames{};
  backtrace(frames.data(), 1);  // loads what it needs, which allocates
  pthread_atfork(nullptr, nullptr, [] { counting = false; });
}

/// Writes without the intercepted calls.
int open_report() {
  if (plan.report[0] == '\0') return -1;
  return static_cast<int>(
      syscall(SYS_openat, AT_FDCWD, plan.report.data(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
}

void put(int file, const char* text) {
  if (file >= 0 && syscall(SYS_write, file, text, std::strlen(text)) < 0) return;
}

constexpr int kMostFrames = 200;

bool is_fragile(void* const* frames, int count) {
  for (int i = 0; i < count; ++i) {
    Dl_info info{};
    if (dladdr(frames[i], &info) == 0 || info.dli_fname == nullptr) continue;
    for (const char* name : kFragile) {
      if (std::strstr(info.dli_fname, name) != nullptr) return true;
    }
  }
  return false;
}

void report_fault(const char* call, const char* path, void* const* frames, int count) {
  const int file = open_report();
  for (const char* text : {"fault ", call, " ", path, "\n"}) put(file, text);
  if (plan.trace && file >= 0) backtrace_symbols_fd(frames, count, file);
  if (file >= 0) syscall(SYS_close, file);
}

/// Whether this allocation may fail: no frame of the stack is in a fragile library.
bool strikes(FaultKind kind, const char* call, const char* path) {
  inside = true;
  std::array<void*, kMostFrames> frames{};
  const int count = backtrace(frames.data(), kMostFrames);
  const bool out = kind != FaultKind::allocation || !is_fragile(frames.data(), count);
  if (out && !struck.exchange(true)) report_fault(call, path, frames.data(), count);
  inside = false;
  return out;
}

int (*real_main)(int, char**, char**) = nullptr;

int counted_main(int argc, char** argv, char** environment) {
  counting = plan.kind != FaultKind::none;
  const int status = real_main(argc, argv, environment);
  counting = false;
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "count %ld\n", calls.load());
  const int file = open_report();
  put(file, text.data());
  if (file >= 0) syscall(SYS_close, file);
  return status;
}

}  // namespace

bool injects(FaultKind kind) {
  return counting && kind == plan.kind && !inside;
}

bool must_fail(FaultKind kind, const char* call, const char* path, bool* write_half) {
  if (!injects(kind)) return false;
  const long number = ++calls;
  if (plan.at == 0 || number < plan.at || (number > plan.at && !plan.lasts)) return false;
  if (!strikes(kind, call, path)) return false;
  if (write_half != nullptr) *write_half = plan.lasts && number == plan.at;
  return true;
}

bool is_watched(const char* path) {
  const std::size_t length = std::strlen(plan.dir.data());
  return length == 0 || std::strncmp(path, plan.dir.data(), length) == 0;
}

const char* path_of(int descriptor) {
  static thread_local std::array<char, PATH_MAX> path;
  std::array<char, 40> link{};
  std::snprintf(link.data(), link.size(), "/proc/self/fd/%d", descriptor);
  const long got = syscall(SYS_readlinkat, AT_FDCWD, link.data(), path.data(), path.size() - 1);
  path[static_cast<std::size_t>(got < 0 ? 0 : got)] = '\0';
  return path.data();
}

int fault_error() {
  return plan.error;
}

bool refuses_exchange() {
  return plan.no_exchange && counting;
}

bool is_large(std::size_t bytes) {
  return bytes >= plan.bytes;
}

void* next_symbol(const char* name) {
  return dlsym(RTLD_NEXT, name);
}

}  // namespace reamsim::test

extern "C" int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(),
                                 void (*fini)(), void (*rtld_fini)(), void* stack_end) {
  using namespace reamsim::test;
  real_main = main;
  const auto next = reinterpret_cast<decltype(&__libc_start_main)>(next_symbol("__libc_start_main"));
  return next(counted_main, argc, argv, init, fini, rtld_fini, stack_end);
}
