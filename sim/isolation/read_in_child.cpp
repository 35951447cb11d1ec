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
#include <thread>

#include "sim/base/process.h"

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

/// Waits until the child has ended, or has to; returns its status, too. Its time counts from the file that it is
/// reading.
std::pair<Ending, int> wait_or_kill(pid_t child, const SharedMemory& memory, int seconds) {
  using std::chrono::microseconds;
  const auto killed = [child](Ending why) {
    kill(child, SIGKILL);
    return std::pair(why, wait_for(child));
  };
  std::uint64_t files = 0;
  double cpu_before = 0;
  for (Clock::time_point begun = Clock::now();;) {
    // A moment: the longer the child has run, the longer.
    const auto run = std::chrono::duration_cast<microseconds>(Clock::now() - begun);
    std::this_thread::sleep_for(std::clamp(run / 16, microseconds(20), microseconds(5'000)));
    int status = 0;
    if (waitpid(child, &status, WNOHANG) != 0) return {Ending::by_itself, status};
    if (stop_requested()) return killed(Ending::stopped);
    const double cpu = cpu_seconds_of(child);
    const auto now = Clock::now();
    if (memory.head().files_read != files) {
      files = memory.head().files_read;
      cpu_before = cpu;
      begun = now;
    }
    if (cpu - cpu_before > seconds) return killed(Ending::out_of_time);
    if (now - begun > std::chrono::seconds(kClockPerCpu * seconds)) return killed(Ending::waits);
  }
}

InputError died(const ForeignFile& file, const std::string& found) {
  return file.error(found, "the file is damaged: give a complete file, or export it again");
}

void throw_unless_done(const ForeignFile& file, const std::shared_ptr<SharedMemory>& memory, const ReadLimits& limits,
                       int status) {
  const ChildOutcome outcome = succeeded(status) ? memory->head().outcome : ChildOutcome::died;
  if (outcome == ChildOutcome::done) return;
  ResultReader reader(memory, file);
  if (outcome == ChildOutcome::wrong_input) {
    auto mistakes = reader.take<std::vector<Mistake>>();
    if (mistakes.empty()) reader.fail();
    throw InputError(std::move(mistakes));
  }
  if (outcome == ChildOutcome::failed) throw RunError(reader.text());
  if (outcome == ChildOutcome::out_of_memory || outcome == ChildOutcome::result_too_large) {
    const std::uint64_t most = outcome == ChildOutcome::out_of_memory ? limits.memory_bytes : memory->capacity();
    throw file.error(fmt::format("reading it needs more than {} MB", most / 1'000'000),
                     "the file is damaged, or too large for its contents: use a smaller one");
  }
  throw died(file, WIFSIGNALED(status) ? fmt::format("the library that reads it crashed (signal {})", WTERMSIG(status))
                                       : "the library that reads it failed");
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

ResultReader run_child(const std::shared_ptr<SharedMemory>& memory, const ForeignFile& file, const ReadLimits& limits,
                       ChildFunction function) {
  const pid_t child = start_child({function, limits.memory_bytes, cpu_seconds(limits), memory->handle()});
  const auto [ending, status] = wait_or_kill(child, *memory, kSlowdown * limits.seconds);
  if (ending == Ending::stopped) throw Interrupted();
  const std::string last(memory->head().path, strnlen(memory->head().path, SharedMemory::Head::kPathBytes));
  const ForeignFile current{last.empty() ? file.path : last, file.key};
  if (ending == Ending::out_of_time) {
    throw died(current, fmt::format("reading it took more than {} s", limits.seconds));
  }
  if (ending == Ending::waits) {
    throw current.error(
        fmt::format("reading it waited for more than {} s", kClockPerCpu * limits.seconds),
        "the disc or the network does not answer, or the system is overloaded: try again, or copy the file "
        "to a local disc");
  }
  // Ctrl-C in a terminal reaches the child too.
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGINT) throw Interrupted();
  throw_unless_done(current, memory, limits, status);
  return {memory, file};
}

}  // namespace reamsim
