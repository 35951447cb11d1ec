#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace reamsim {

/// A program to start, found in PATH. File descriptors stay the caller's.
struct ChildCommand {
  std::vector<std::string> arguments;  ///< the program first
  std::string dir{};                   ///< its working directory; "": ours
  int in = -1, out = -1, err = -1;     ///< -1: /dev/null
  bool own_group = false;              ///< not interrupted by Ctrl-C in the terminal
};

/// Starts the program. Returns 0 or an error number.
int spawn(ChildCommand command, pid_t& child);

/// Waits for a child. Returns its status as waitpid().
int wait_for(pid_t child);

/// Did the child exit with status 0?
bool succeeded(int status);

/// A file in memory, for the output of a child.
class MemoryFile {
 public:
  /// `purpose`: of the file, for the message. Throws RunError.
  explicit MemoryFile(const std::string& purpose);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] int descriptor() const { return fd_; }
  [[nodiscard]] std::string contents() const;

 private:
  int fd_;
};

}  // namespace reamsim
