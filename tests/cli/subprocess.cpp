// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/cli/subprocess.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

extern char** environ;

namespace reamsim::test {

namespace {

constexpr auto kTimeLimit = std::chrono::seconds(REAMSIM_PROGRAM_TIMEOUT_S);
constexpr auto kPoll = std::chrono::milliseconds(5);

/// A file without a name that takes what a program writes.
class Capture {
 public:
  Capture() : file_(std::tmpfile()) {
    if (file_ == nullptr) throw std::runtime_error("cannot make a temporary file");
  }
  ~Capture() { (void)std::fclose(file_); }
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  [[nodiscard]] int descriptor() const { return fileno(file_); }
  std::string text() {
    std::rewind(file_);
    std::string out;
    char chunk[4096];
    for (std::size_t n = 0; (n = std::fread(chunk, 1, sizeof chunk, file_)) > 0;) out.append(chunk, n);
    return out;
  }

 private:
  std::FILE* file_;
};

/// Lowers our own limit of file sizes, which the child inherits, and puts it back.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(long bytes) {
    getrlimit(RLIMIT_FSIZE, &old_);
    if (bytes < 0) return;
    rlimit lower = old_;
    lower.rlim_cur = static_cast<rlim_t>(bytes);
    setrlimit(RLIMIT_FSIZE, &lower);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &old_); }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit old_{};
};

std::vector<std::string> environment_with(const std::map<std::string, std::string>& changes) {
  std::vector<std::string> out;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (!changes.contains(text.substr(0, text.find('=')))) out.push_back(text);
  }
  for (const auto& [name, value] : changes) out.push_back(name + "=" + value);
  return out;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> out;
  for (auto& text : texts) out.push_back(text.data());
  out.push_back(nullptr);
  return out;
}

pid_t spawn(const std::string& program, const ProgramCall& call, const Capture& out, const Capture& err) {
  std::vector<std::string> arguments{program};
  arguments.insert(arguments.end(), call.arguments.begin(), call.arguments.end());
  std::vector<std::string> environment = environment_with(call.environment);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (call.closed_output) {
    posix_spawn_file_actions_addclose(&actions, STDOUT_FILENO);
  } else {
    posix_spawn_file_actions_adddup2(&actions, out.descriptor(), STDOUT_FILENO);
  }
  posix_spawn_file_actions_adddup2(&actions, err.descriptor(), STDERR_FILENO);
  if (!call.folder.empty()) posix_spawn_file_actions_addchdir_np(&actions, call.folder.c_str());
  const FileSizeLimit limit(call.file_size_limit);
  pid_t pid = 0;
  const int error =
      posix_spawn(&pid, program.c_str(), &actions, nullptr, pointers(arguments).data(), pointers(environment).data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("cannot start " + program + ": " + std::strerror(error));
  return pid;
}

int wait_for(pid_t pid, const ProgramCall& call, rusage& usage) {
  const auto start = std::chrono::steady_clock::now();
  bool interrupted = false, killed = false;
  int status = 0;
  while (wait4(pid, &status, WNOHANG, &usage) == 0) {
    if (call.interrupt_when && !interrupted && call.interrupt_when()) {
      kill(pid, call.interrupt_signal);
      interrupted = true;
    }
    if (!killed && std::chrono::steady_clock::now() - start > kTimeLimit) {
      kill(pid, SIGKILL);
      killed = true;
    }
    std::this_thread::sleep_for(kPoll);
  }
  return status;
}

}  // namespace

ProgramResult run_program(const std::string& program, const ProgramCall& call) {
  Capture out, err;
  rusage usage{};
  const int status = wait_for(spawn(program, call, out, err), call, usage);
  ProgramResult result;
  result.peak_mb = static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;  // Linux counts KiB
  if (WIFEXITED(status)) result.status = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  result.out = out.text();
  result.err = err.text();
  return result;
}

}  // namespace reamsim::test
