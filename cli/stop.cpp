#include "cli/stop.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <thread>

namespace reamsim {

namespace {

// Global, because a signal handler can reach nothing else.
volatile std::sig_atomic_t stop_signal = 0;
int wake_pipe[2] = {-1, -1};

std::atomic<int> graces = 0;
std::atomic<int> exit_status = -1;
std::mutex end_mutex;
std::function<StopOutcome()> end_by_force;  // guarded by end_mutex

void request_stop(int) {
  stop_signal = 1;
  const char byte = 0;
  if (write(wake_pipe[1], &byte, 1) < 0) return;  // the pipe is full: the thread is awake
}

/// Waits for a signal. Ends the process where the command has not ended soon after.
void watch_for_stop() {
  using namespace std::chrono_literals;
  char byte = 0;
  while (read(wake_pipe[0], &byte, 1) != 1) {
  }
  do {
    while (graces > 0) std::this_thread::sleep_for(20ms);
    std::this_thread::sleep_for(700ms);
  } while (graces > 0);
  if (const int status = exit_status; status >= 0) _exit(status);  // only the libraries' own end takes long
  StopOutcome outcome;
  {
    const std::lock_guard lock(end_mutex);
    if (end_by_force) outcome = end_by_force();
  }
  std::fprintf(stderr, "reamsim: error: %s\n", outcome.message.c_str());
  _exit(outcome.status);
}

}  // namespace

bool stop_requested() {
  return stop_signal != 0;
}

void install_stop_handler() {
  if (pipe(wake_pipe) == 0) std::thread(watch_for_stop).detach();
  struct sigaction action = {}, before = {};
  action.sa_handler = request_stop;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) {
    // nohup and shells ignore some for a program that is to go on.
    if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
    sigaction(signal, &action, nullptr);
  }
  // A full disk or a size limit is reported where the write fails.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

int end_with(int status) {
  exit_status = status;
  return status;
}

ForcedStop::ForcedStop(std::function<StopOutcome()> end) {
  const std::lock_guard lock(end_mutex);
  end_by_force = std::move(end);
}

ForcedStop::~ForcedStop() {
  const std::lock_guard lock(end_mutex);
  end_by_force = nullptr;
}

StopGrace::StopGrace() {
  ++graces;
}

StopGrace::~StopGrace() {
  --graces;
}

}  // namespace reamsim
