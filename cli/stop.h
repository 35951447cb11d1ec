// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <memory>
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

/// While what it returns exists, `end` tidies up when the command is ended by force, on another thread, while the
/// command still works.
std::shared_ptr<void> on_forced_stop(std::function<StopOutcome()> end);

/// That of a command that writes `file`, which has the ending ".tmp" until it is complete.
std::shared_ptr<void> removing_unfinished(const std::string& file);

/// That of a command whose unfinished results in `folder` (OutputFolder) are of no use.
template <class Folder>
std::shared_ptr<void> abandoning(Folder& folder) {
  return on_forced_stop([&folder] {
    folder.abandon();
    return StopOutcome{};
  });
}

/// While what it returns exists, a command that ends by itself is given more time: it writes what would be lost.
std::shared_ptr<void> stop_grace();

}  // namespace reamsim
