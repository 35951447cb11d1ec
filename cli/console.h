// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cli/stop.h"
#include "sim/base/report.h"
#include "sim/base/stopwatch.h"

namespace reamsim {

/// Messages: results and progress on stdout, warnings and errors on stderr.
class Console {
 public:
  bool quiet = false;
  bool verbose = false;

  /// One line, printable().
  void say(const std::string& line) const;
  /// say() for each line of a text.
  void say_lines(std::string_view text) const;
  /// "reamsim: warning: ..." on stderr, in colour on a terminal (styled()); also when quiet.
  void warn(const std::string& line) const;
  /// Prints the warnings of a stage, and its notes when verbose. Clears the report.
  void print(Report& report) const;
};

/// Whether text for this stream may have colours and a line may be drawn again: a terminal that is not dumb.
bool is_terminal(int descriptor);
/// Whether messages on standard error have colours: a terminal, and NO_COLOR (no-color.org) is not set.
bool has_colors();

/// Progress of one stage: a bar with rate and time left on a terminal, a line every tenth elsewhere, nothing when
/// quiet.
class Progress {
 public:
  Progress(const Console& console, std::string stage, std::string unit);
  void update(std::int64_t done, std::int64_t total);
  /// `fraction` of the expected time has passed, and `what` begins: for stages whose parts take different times.
  void update_part(double fraction, const std::string& what);
  /// Ends the bar's line.
  void finish();

 private:
  const Console& console_;
  std::string stage_;
  std::string unit_;
  bool terminal_;
  bool open_ = false;
  [[nodiscard]] bool is_due(double fraction);
  void draw(double fraction, const std::string& text);

  int last_tenth_ = 0;
  double last_drawn_s_ = -1;
  Stopwatch watch_;
};

}  // namespace reamsim
