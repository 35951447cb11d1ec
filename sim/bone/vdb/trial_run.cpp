#include "sim/bone/vdb/trial_run.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

namespace reamsim {

namespace {

/// Address space of this process, bytes.
std::uint64_t address_space_bytes() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
}

void limit(__rlimit_resource resource, std::uint64_t most) {
  const rlimit both{most, most};
  setrlimit(resource, &both);
}

[[noreturn]] void run_as_child(const std::function<void()>& work, std::uint64_t most_bytes, int seconds) {
  limit(RLIMIT_AS, most_bytes);
  limit(RLIMIT_CPU, static_cast<std::uint64_t>(seconds));
  limit(RLIMIT_CORE, 0);
  for (const int fatal : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGILL, SIGXCPU}) signal(fatal, SIG_DFL);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  dup2(nowhere, STDERR_FILENO);  // the library's complaints would stand beside our one line
  try {
    work();
  } catch (...) {
    _exit(1);
  }
  _exit(0);
}

/// The child's status; a child that outlives `seconds` is ended.
int wait_for(pid_t child, int seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > end) kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return status;
}

}  // namespace

bool succeeds_in_child(const std::function<void()>& work, std::uint64_t memory_bytes, int seconds) {
  const std::uint64_t most_bytes = address_space_bytes() + memory_bytes;
  const pid_t child = fork();
  if (child < 0) return true;
  if (child == 0) run_as_child(work, most_bytes, seconds);
  const int status = wait_for(child, 4 * seconds);  // wall time, on a busy machine
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace reamsim
