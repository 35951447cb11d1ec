// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <string>

namespace reamsim {

/// Exit statuses of a command that a signal ended: without and with a checkpoint to continue from.
inline constexpr int kInterruptedStatus = 130, kSuspendedStatus = 75;

/// Whether SIGINT, SIGTERM, SIGHUP or SIGUSR1 has arrived since install_stop_handler().
bool stop_requested();
/// Handles these signals. A command that does not end by itself soon after one of them is ended by force.
void install_stop_handler();

/// Notes the exit status of a command that has ended, and returns it.
int end_with(int status);

/// Exit status and message after a signal.
struct StopOutcome {
  int status = kInterruptedStatus;
  std::string message = "interrupted";
};

/// `end` tidies up when a command is ended by force, on another thread, while the command still works.
class ForcedStop {
 public:
  explicit ForcedStop(std::function<StopOutcome()> end);
  ~ForcedStop();
  ForcedStop(const ForcedStop&) = delete;
  ForcedStop& operator=(const ForcedStop&) = delete;
};

/// The ForcedStop of a command that writes `file`, which has the ending ".tmp" until it is complete.
ForcedStop removing_unfinished(const std::string& file);

/// The ForcedStop of a command whose unfinished results in `folder` (OutputFolder) are of no use.
template <class Folder>
ForcedStop abandoning(Folder& folder) {
  return ForcedStop([&folder] {
    folder.abandon();
    return StopOutcome{};
  });
}

/// While it exists, a command that ends by itself is given more time: it writes what would be lost.
class StopGrace {
 public:
  StopGrace();
  ~StopGrace();
  StopGrace(const StopGrace&) = delete;
  StopGrace& operator=(const StopGrace&) = delete;
};

}  // namespace reamsim
