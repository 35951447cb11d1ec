// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/console.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <thread>

#include "sim/isolation/read_in_child.h"

namespace reamsim {

namespace {

std::atomic<bool> stopped = false;
std::atomic<int> graces = 0;
std::atomic<int> exit_status = -1;
std::mutex end_mutex;
std::function<InterruptedRun()> end_by_force;  // guarded by end_mutex

[[noreturn]] void end_process(int status) {
  stop_reader_server();
  _exit(status);
}

/// Waits for one of the signals. Ends the process where the command has not ended soon after.
void watch_for_stop(sigset_t signals) {
  using namespace std::chrono_literals;
  int signal = 0;
  while (sigwait(&signals, &signal) != 0) {
  }
  stopped = true;
  do {
    while (graces > 0) std::this_thread::sleep_for(20ms);
    std::this_thread::sleep_for(700ms);
  } while (graces > 0);
  if (const int status = exit_status; status >= 0) end_process(status);  // only the libraries' own end takes long
  InterruptedRun outcome;
  {
    const std::lock_guard lock(end_mutex);
    if (end_by_force) outcome = end_by_force();
  }
  std::fprintf(stderr, "reamsim: error: %s\n", outcome.message.c_str());
  end_process(outcome.saved ? kSuspendedStatus : kInterruptedStatus);
}

}  // namespace

bool stop_requested() {
  return stopped;
}

void install_stop_handler() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) {
    struct sigaction before = {};
    // nohup and shells ignore some for a program that is to go on.
    if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
    sigaddset(&signals, signal);
  }
  // Blocked in all threads, and taken by one of their own: a handler would be replaced by that of the kernel compiler.
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread(watch_for_stop, signals).detach();
  interrupt_reading_when(stop_requested);
  // A full disk or a size limit is reported where the write fails.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

int end_with(int status) {
  exit_status = status;
  return status;
}

std::shared_ptr<void> on_forced_stop(std::function<InterruptedRun()> end) {
  const auto set = [](std::function<InterruptedRun()> now) {
    const std::lock_guard lock(end_mutex);
    end_by_force = std::move(now);
  };
  set(std::move(end));
  return {nullptr, [set](void*) { set(nullptr); }};
}

std::shared_ptr<void> removing_unfinished(const std::string& file) {
  return on_forced_stop([unfinished = file + ".tmp"] {
    std::error_code ignored;
    std::filesystem::remove(unfinished, ignored);
    return InterruptedRun{};
  });
}

std::shared_ptr<void> stop_grace() {
  ++graces;
  return {nullptr, [](void*) { --graces; }};
}

}  // namespace reamsim
