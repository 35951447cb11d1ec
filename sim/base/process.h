// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <sys/types.h>

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

/// A program to start.
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

/// Whether a child with this status exited with 0.
bool succeeded(int status);

}  // namespace reamsim
