// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"

namespace reamsim {

/// Columns of a table in a terminal.
inline constexpr std::size_t kTerminalWidth = 100;

/// Messages: results and progress on stdout, warnings and errors on stderr.
class Console {
 public:
  bool quiet = false;
  bool verbose = false;

  /// One line, printable().
  void say(const std::string& line) const;
  /// say() for each line of a text.
  void say_lines(std::string_view text) const;
  /// "reamsim: warning: ..." on stderr, in colour on a terminal; also when quiet.
  void warn(const std::string& line) const;
  /// Prints the warnings of a stage, and its notes when verbose. Clears the report.
  void print(Diagnostics& report) const;
};

/// What it returns prints the report where an exception ends its life: a warning may name the cause of the error.
std::shared_ptr<void> print_on_error(Diagnostics& report, const Console& console);

/// Whether messages on standard error have colours: a terminal, and NO_COLOR (no-color.org) is not set.
bool has_colors();

/// Progress of one stage: a bar on a terminal; elsewhere a line every tenth, and at once of more than a minute.
class Progress {
 public:
  Progress(const Console& console, std::string stage, std::string unit);
  ~Progress() { finish(); }  // an error message begins on a line of its own
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void update(std::int64_t done, std::int64_t total);
  /// `fraction` of the expected time has passed, and `what` begins: for stages whose parts take different times.
  /// `always`: a log names it as well, however short it is.
  void update_part(double fraction, const std::string& what, bool always = false);
  /// Ends the bar's line.
  void finish();

 private:
  const Console& console_;
  std::string stage_;
  std::string unit_;
  bool terminal_;
  bool open_ = false;
  [[nodiscard]] bool is_due(double fraction, double left_s);
  void draw(double fraction, const std::string& text);

  int last_tenth_ = 0;
  bool named_ = false;  ///< a log has a line
  double last_drawn_s_ = -1;
  Stopwatch watch_;
};

/// Prints all that a command with --json writes to standard output. Bytes that are no UTF-8 are replaced.
void print_json(const nlohmann::ordered_json& json);

/// Calls `work` with a console that is quiet. Where it throws, prints {"program", "ok": false, "mistakes": [...]}, with
/// "error" where the input is not to blame, and throws again.
void run_with_json(const Console& console, const std::function<void(const Console&)>& work);

/// Exit statuses of a command that a signal ended: without and with a checkpoint to continue from.
inline constexpr int kInterruptedStatus = 130, kSuspendedStatus = 75;

/// Whether SIGINT, SIGTERM, SIGHUP or SIGUSR1 has arrived since install_stop_handler().
bool stop_requested();
/// Handles these signals. A command that does not end by itself soon after one of them is ended by force.
void install_stop_handler();

/// Notes the exit status of a command that has ended, and returns it.
int end_with(int status);

/// While what it returns exists, `end` tidies up when the command is ended by force, on another thread, while the
/// command still works.
std::shared_ptr<void> on_forced_stop(std::function<InterruptedRun()> end);

/// That of a command that writes `file`, which has the ending ".tmp" until it is complete.
std::shared_ptr<void> removing_unfinished(const std::string& file);

/// That of a command whose unfinished results in `folder` (OutputFolder) are of no use.
template <class Folder>
std::shared_ptr<void> abandoning(Folder& folder) {
  return on_forced_stop([&folder] {
    folder.abandon();
    return InterruptedRun{};
  });
}

/// While what it returns exists, a command that ends by itself is given more time: it writes what would be lost.
std::shared_ptr<void> stop_grace();

}  // namespace reamsim
