// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <sys/types.h>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace reamsim {

/// A file in memory, for the output of a program.
class MemoryFile {
 public:
  /// `purpose`: for the message. Throws RunError.
  explicit MemoryFile(const std::string& purpose);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] std::string contents() const;

 private:
  int descriptor_;
};

struct ChildCommand {
  std::vector<std::string> arguments;  ///< the program first, which is looked up in PATH
  std::string dir = {};                ///< its working directory; "" = that of this process
  int in = -1, out = -1, err = -1;     ///< file descriptors; −1 = /dev/null
  bool own_group = false;              ///< Ctrl-C in the terminal does not interrupt it
};

/// Starts a program and sets `child`. Returns 0 or an error number.
int spawn(ChildCommand command, pid_t& child);

/// Waits until the child ends. Returns its status, as waitpid() reports it.
int wait_for(pid_t child);

bool succeeded(int status);

/// Returns freed memory to the system, which the C library would keep. Call it after a stage with much of it.
void return_free_memory();

/// The limit of the address space of this process (`ulimit -v`), bytes; none: unlimited.
std::optional<std::uint64_t> address_space_limit();

/// The address space that this process has reserved, bytes; 0 where the system does not say.
std::uint64_t address_space_in_use();

/// "the address space is limited to 300 MB (ulimit -v)" between two texts; "" where it is not.
std::string address_space_note(const std::string& before = "", const std::string& after = "");

}  // namespace reamsim
