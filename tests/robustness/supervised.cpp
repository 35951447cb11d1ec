// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "supervised.h"

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <new>
#include <stdexcept>

#include "sim/base/error.h"

namespace reamsim::test {

namespace {

constexpr unsigned kMostSeconds = 60;
constexpr rlim_t kMostMemory = rlim_t{6} << 30;

enum class End : int { none, accepted, wrong_input, other };

/// Shared between the two processes.
struct Note {
  End end = End::none;
  char text[2048] = {};

  void set(End how, const char* what) {
    end = how;
    std::strncpy(text, what, sizeof text - 1);
  }
};

class SharedNote {
 public:
  SharedNote() : memory_(mmap(nullptr, sizeof(Note), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (memory_ == MAP_FAILED) throw std::runtime_error("no shared memory");
    new (memory_) Note;
  }
  ~SharedNote() { munmap(memory_, sizeof(Note)); }
  SharedNote(const SharedNote&) = delete;
  SharedNote& operator=(const SharedNote&) = delete;
  Note* operator->() { return static_cast<Note*>(memory_); }

 private:
  void* memory_;
};

[[noreturn]] void do_and_exit(const std::function<void()>& work, SharedNote& note) {
  setpgid(0, 0);  // with the programs that the work starts, which must not outlive it
  const rlimit memory{kMostMemory, kMostMemory};
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // their shadow memory is larger
  setrlimit(RLIMIT_AS, &memory);
#else
  (void)memory;
#endif
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  alarm(kMostSeconds);
  try {
    work();
    note->set(End::accepted, "");
  } catch (const InputError& error) {
    note->set(End::wrong_input, error.what());
  } catch (const std::exception& error) {
    note->set(End::other, error.what());
  }
  _exit(0);
}

}  // namespace

Verdict supervised(const std::function<void()>& work) {
  SharedNote note;
  const auto begun = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) do_and_exit(work, note);
  int status = 0;
  rusage usage{};
  while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  kill(-child, SIGKILL);
  Verdict out;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  out.peak_mb = static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;  // Linux counts KiB
  if (WIFSIGNALED(status)) out.signal = WTERMSIG(status);
  out.accepted = note->end == End::accepted;
  if (note->end == End::wrong_input) out.message = note->text;
  if (note->end == End::other) out.failure = note->text;
  if (note->end == End::none && out.signal == 0) out.failure = "exited";
  return out;
}

}  // namespace reamsim::test
