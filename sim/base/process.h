#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
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

struct ChildLimits {
  std::uint64_t memory_bytes = 0;  ///< more than what this process has; 0 = no limit
  int seconds = 0;                 ///< of the processor; 0 = no limit
};

/// Runs `work` in a copy of this process and returns the status of the copy, as waitpid() reports it; 0 where no copy
/// can be made. It exits with 1 if `work` throws. For libraries that damaged input can crash or send into endless
/// loops: the child fails alone, its standard error is discarded, and what `work` changes is lost with it. `work` must
/// start no threads.
int run_in_child(const std::function<void()>& work, const ChildLimits& limits = {});

}  // namespace reamsim
