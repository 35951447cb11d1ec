// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <sys/types.h>

#include "sim/isolation/child_result.h"

namespace reamsim {

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

/// Whether the sandbox restricts system calls on this kernel. Forks once.
bool restricts_system_calls();

}  // namespace reamsim
