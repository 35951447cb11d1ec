// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <string>
#include <tuple>

#include "sim/isolation/child_result.h"

namespace reamsim {

// Every file of foreign origin is read by a child process: libraries for meshes, images and grids crash, loop or
// allocate without limit on some damaged files, and have had defects that run code of the file's author. The child has
// limits (start_child()) and hands back plain arrays. Only the child fails.

// A fork of a process with several threads inherits locks that no thread will ever release: its memory is a copy, but
// only the forking thread exists in it. The readers are therefore started by a process of one thread, the server, which
// is itself forked before the program starts threads.

/// What a child runs: takes its arguments from the reader, and writes its result.
using ChildFunction = void (*)(ResultReader& arguments, ResultWriter& result);

/// What a child is started with.
struct ChildStart {
  ChildFunction function = nullptr;  ///< at the same address in server and child, which are forks of this process
  std::uint64_t memory_bytes = 0;    ///< address space for reading, beyond what the process has
  int cpu_seconds = 0;
  SharedMemory::Handle memory{};  ///< holds the arguments, and later the result
};

/// Starts the server, if this has not been done. Call it first in main(); otherwise the first child starts it.
/// Throws RunError.
void start_reader_server();

/// Ends the server, for which the system's first process may never wait in a container. Runs when the program exits;
/// call it before _exit(). Does nothing in a fork of the process. Never waits for another thread.
void stop_reader_server();

/// Starts a child of this process in a sandbox: limited memory and processor time, few open files, files that are not
/// written, no core dump; and, where the kernel has seccomp, only the system calls that reading files needs. Others
/// fail with EPERM, among them network, new processes, programs, ptrace, signals to others, and opening for writing.
/// Lower limits of the system remain. Thread-safe. Throws RunError.
pid_t start_child(const ChildStart& start);

struct ReadLimits {
  std::uint64_t memory_bytes = std::uint64_t{768} << 20;  ///< address space for reading
  std::uint64_t result_bytes = std::uint64_t{16} << 20;
  int seconds = 3;  ///< of the processor, for each file; ten times as many on the clock, for slow discs
  int files = 1;

  /// More memory and time for a file of `file_bytes` that becomes `contents_bytes` in memory.
  [[nodiscard]] ReadLimits with(std::uint64_t file_bytes, std::uint64_t contents_bytes) const;
};

/// Length of a file, bytes; 0 if it cannot be found out.
std::uint64_t bytes_of_file(const std::string& path);

/// Sets the function that says whether the user has asked the program to stop; several times a second it is called.
void interrupt_reading_when(bool (*stop)());

/// read_in_child() of a function whose arguments are in `memory`.
ResultReader run_child(const std::shared_ptr<SharedMemory>& memory, const ForeignFile& file, const ReadLimits& limits,
                       ChildFunction function);

/// Calls `Read(result, arguments...)` in a child process and returns what it wrote to `result`, a ResultWriter. The
/// arguments are plain values, texts and vectors of them, which the child takes as copies. `Read` may throw InputError
/// or RunError, which this function throws again.
/// Throws InputError, with the file that was being read, if the child crashes or exceeds a limit; Interrupted within
/// a fraction of a second if the function of interrupt_reading_when() says so; RunError if no child can be started.
template <auto Read, class... Arguments>
ResultReader read_in_child(const ForeignFile& file, const ReadLimits& limits, const Arguments&... arguments) {
  const auto memory = std::make_shared<SharedMemory>(limits.result_bytes);
  ResultWriter writer(*memory);
  (writer.put(arguments), ...);
  return run_child(memory, file, limits, [](ResultReader& in, ResultWriter& out) {
    // Braces, so that they are taken in their order.
    const std::tuple<Arguments...> values{in.take<Arguments>()...};
    std::apply([&out](const Arguments&... value) { Read(out, value...); }, values);
  });
}

}  // namespace reamsim
