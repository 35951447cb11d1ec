#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace reamsim {

/// A file in memory that takes what a program prints.
class ProgramOutput {
 public:
  /// Throws RunError when there is no memory for it.
  ProgramOutput();
  ~ProgramOutput();
  ProgramOutput(const ProgramOutput&) = delete;
  ProgramOutput& operator=(const ProgramOutput&) = delete;

  [[nodiscard]] int descriptor() const { return descriptor_; }
  /// All that has been printed so far.
  [[nodiscard]] std::string text() const;

 private:
  int descriptor_;
};

/// How a program is started. File descriptors: −1 stands for /dev/null.
struct ProgramStart {
  std::vector<std::string> arguments;  ///< first the name of the program, which is looked up in PATH
  std::string folder;                  ///< where it runs; "" = here
  int in = -1;
  int out = -1;
  int err = -1;
  bool own_group = false;  ///< Ctrl-C does not reach it
};

/// Starts a program and sets `child`. Returns 0 or an error number.
int start_program(ProgramStart start, pid_t& child);

/// Waits until the child ends. Returns its status, as waitpid() reports it.
int wait_for(pid_t child);

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
