// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/isolation/read_in_child.h"

#include <fmt/core.h>
#include <sys/wait.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <limits>
#include <optional>
#include <thread>

#include "sim/base/error.h"
#include "sim/base/process.h"
#include "sim/isolation/child_result.h"
#include "sim/isolation/reader_server.h"

namespace reamsim {

namespace {

using Clock = std::chrono::steady_clock;

// Global, because the readers know nothing of the program's signals.
std::atomic<bool (*)()> stop_query = nullptr;

bool stop_requested() {
  bool (*const query)() = stop_query;
  return query != nullptr && query();
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kSlowdown = 10;
#else
constexpr int kSlowdown = 1;
#endif
/// Wall time per second of the processor: other programs, and discs on a network, take the rest.
constexpr int kClockPerCpu = 10;

/// For all files. The parent counts for each file, and comes first: it says what happened.
int cpu_seconds(const ReadLimits& limits) {
  constexpr std::int64_t kAfterParent = 2;
  const std::int64_t all = std::int64_t{kSlowdown} * limits.seconds * std::max(1, limits.files) + kAfterParent;
  return static_cast<int>(std::min<std::int64_t>(all, std::numeric_limits<int>::max()));
}

double cpu_seconds_of(pid_t child) {
  clockid_t clock{};
  timespec used{};
  if (clock_getcpuclockid(child, &clock) != 0 || clock_gettime(clock, &used) != 0) return 0;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

/// `waits`: out of time on the clock, with time of the processor left.
enum class Ending { by_itself, out_of_time, waits, stopped };

class Watch {
 public:
  Watch(pid_t child, const SharedMemory& memory, const ReadLimits& limits)
      : child_(child), memory_(memory), seconds_(kSlowdown * limits.seconds) {}

  Ending wait() {
    while (!ended()) {
      if (stop_requested()) return killed(Ending::stopped);
      if (const auto end = time_is_over()) return killed(*end);
    }
    return Ending::by_itself;
  }
  [[nodiscard]] int status() const { return status_; }

 private:
  Ending killed(Ending why) {
    kill(child_, SIGKILL);
    status_ = wait_for(child_);
    return why;
  }
  /// Waits a moment: the longer the child has run, the longer.
  bool ended() {
    using std::chrono::microseconds;
    const auto run = std::chrono::duration_cast<microseconds>(Clock::now() - begun_);
    std::this_thread::sleep_for(std::clamp(run / 16, microseconds(20), microseconds(5'000)));
    return waitpid(child_, &status_, WNOHANG) != 0;
  }

  /// Counts from the file that is being read.
  std::optional<Ending> time_is_over() {
    const double cpu = cpu_seconds_of(child_);
    const auto now = Clock::now();
    const std::uint64_t files = memory_.head().files_read;
    if (files != files_) {
      files_ = files;
      cpu_before_ = cpu;
      begun_ = now;
    }
    if (cpu - cpu_before_ > seconds_) return Ending::out_of_time;
    if (now - begun_ > std::chrono::seconds(kClockPerCpu * seconds_)) return Ending::waits;
    return std::nullopt;
  }

  pid_t child_;
  const SharedMemory& memory_;
  int seconds_;
  int status_ = 0;
  std::uint64_t files_ = 0;
  double cpu_before_ = 0;
  Clock::time_point begun_ = Clock::now();
};

ForeignFile current_file(const ForeignFile& file, const SharedMemory& memory) {
  const char* path = memory.head().path;
  const std::string current(path, strnlen(path, SharedMemory::Head::kPathBytes));
  return {current.empty() ? file.path : current, file.key};
}

[[noreturn]] void throw_died(const ForeignFile& file, const std::string& found) {
  throw InputError({file.path, 0, 0}, file.key, found, "the file is damaged: give a complete file, or export it again");
}

std::string crash_of(int status) {
  if (!WIFSIGNALED(status)) return "the library that reads it failed";
  return fmt::format("the library that reads it crashed (signal {})", WTERMSIG(status));
}

void throw_unless_done(const ForeignFile& file, const SharedMemory& memory, const ReadLimits& limits, int status) {
  ResultReader reader(memory, file.path, file.key);
  const auto too_much = [&](std::uint64_t bytes) {
    throw InputError({file.path, 0, 0}, file.key, fmt::format("reading it needs more than {} MB", bytes / 1'000'000),
                     "the file is damaged, or too large for its contents: use a smaller one");
  };
  if (!succeeded(status)) throw_died(file, crash_of(status));
  switch (memory.head().outcome) {
    case ChildOutcome::done:
      return;
    case ChildOutcome::wrong_input:
      throw_mistakes(reader);
    case ChildOutcome::failed:
      throw RunError(reader.text());
    case ChildOutcome::out_of_memory:
      return too_much(limits.memory_bytes);
    case ChildOutcome::result_too_large:
      return too_much(memory.capacity());
    case ChildOutcome::died:
      break;
  }
  throw_died(file, crash_of(status));  // it exited without an error
}

}  // namespace

void interrupt_reading_when(bool (*stop)()) {
  stop_query = stop;
}

ReadLimits ReadLimits::with(std::uint64_t file_bytes, std::uint64_t contents_bytes) const {
  constexpr std::uint64_t kFileBytesPerSecond = 8'000'000;
  constexpr std::uint64_t kContentsPerSecond = 50'000'000;
  constexpr std::uint64_t kMostSeconds = 100'000;
  ReadLimits out = *this;
  out.memory_bytes += file_bytes + contents_bytes;
  const std::uint64_t more = file_bytes / kFileBytesPerSecond + contents_bytes / kContentsPerSecond;
  out.seconds += static_cast<int>(std::min(more, kMostSeconds));
  return out;
}

std::uint64_t bytes_of_file(const std::string& path) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  return error ? 0 : bytes;
}

ChildResult run_child(std::unique_ptr<SharedMemory> memory, const ForeignFile& file, const ReadLimits& limits,
                      ChildFunction function) {
  const pid_t child = start_child({function, limits.memory_bytes, cpu_seconds(limits), memory->handle()});
  Watch watch(child, *memory, limits);
  const Ending ending = watch.wait();
  if (ending == Ending::stopped) throw Interrupted();
  const ForeignFile current = current_file(file, *memory);
  if (ending == Ending::out_of_time) {
    throw_died(current, fmt::format("reading it took more than {} s", limits.seconds));
  }
  if (ending == Ending::waits) {
    throw InputError(
        {current.path, 0, 0}, current.key,
        fmt::format("reading it waited for more than {} s", kClockPerCpu * limits.seconds),
        "the disc or the network does not answer, or the system is overloaded: try again, or copy the file "
        "to a local disc");
  }
  // Ctrl-C in a terminal reaches the child too.
  if (WIFSIGNALED(watch.status()) && WTERMSIG(watch.status()) == SIGINT) throw Interrupted();
  throw_unless_done(current, *memory, limits, watch.status());
  return {std::move(memory), file};
}

}  // namespace reamsim
