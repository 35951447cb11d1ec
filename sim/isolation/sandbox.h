// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>

namespace reamsim {

/// What a child process may use. Limits of the system that are lower remain.
struct SandboxLimits {
  std::uint64_t memory_bytes = 0;  ///< address space, beyond what the process has
  int cpu_seconds = 0;
};

/// Restricts this process, for ever: memory, processor time, few open files, files that are not written, no core dump;
/// and, where the kernel has seccomp, only the system calls that reading files needs. Others fail with EPERM, among
/// them network, new processes, programs, ptrace, signals to others, and opening for writing.
/// Closes every file but the standard streams and `keep`. Returns whether system calls are restricted.
bool enter_sandbox(const SandboxLimits& limits, int keep);

/// Connects the standard streams to /dev/null and closes every other file but `keep`. Returns the new number of that
/// one.
int close_files(int keep);

/// Whether enter_sandbox() restricts system calls on this kernel. Forks once.
bool restricts_system_calls();

}  // namespace reamsim
