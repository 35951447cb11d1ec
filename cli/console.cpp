// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/console.h"

#include <fmt/core.h>
#include <unistd.h>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>

#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr int kBarCells = 30;
constexpr double kRedrawSeconds = 0.1;
/// A log has a line at once where more time is left: a silent first tenth would look like a program that hangs.
constexpr double kLongSeconds = 60;
/// Of parts: the time of less than that says nothing of the rest.
constexpr double kLeastFraction = 0.02;

/// Whether a line may be drawn again and have colours: a terminal that is not dumb.
bool is_terminal(int descriptor) {
  const char* const kind = std::getenv("TERM");
  return isatty(descriptor) == 1 && kind != nullptr && std::strcmp(kind, "dumb") != 0;
}

using Json = nlohmann::ordered_json;

Json json_of(const Mistake& mistake) {
  Json out;
  if (!mistake.where.file.empty()) out["file"] = mistake.where.file;
  if (mistake.where.line > 0) out["line"] = mistake.where.line;
  if (mistake.where.column > 0) out["column"] = mistake.where.column;
  if (!mistake.key.empty()) out["key"] = mistake.key;
  out["found"] = mistake.found;
  if (!mistake.expected.empty()) out["expected"] = mistake.expected;
  return out;
}

}  // namespace

void Console::say(const std::string& line) const {
  if (!quiet) std::printf("%s\n", printable(line).c_str());
  std::fflush(stdout);
}

void Console::say_lines(std::string_view text) const {
  for (std::size_t end; !text.empty(); text.remove_prefix(std::min(end + 1, text.size()))) {
    end = std::min(text.find('\n'), text.size());
    say(std::string(text.substr(0, end)));
  }
}

void Console::warn(const std::string& line) const {
  const char* const label = has_colors() ? "\033[33mreamsim: warning:\033[0m" : "reamsim: warning:";
  std::fprintf(stderr, "%s %s\n", label, printable(line).c_str());
}

void Console::print(Diagnostics& report) const {
  if (verbose) {
    for (const auto& note : report.notes) say("  " + note);
  }
  for (const auto& warning : report.warnings) warn(warning);
  for (const auto& listing : report.listings) std::fprintf(stderr, "reamsim: %s\n", printable(listing).c_str());
  report = {};
}

std::shared_ptr<void> print_on_error(Diagnostics& report, const Console& console) {
  return {nullptr, [&report, &console, before = std::uncaught_exceptions()](void*) {
            if (std::uncaught_exceptions() == before) return;
            try {
              console.print(report);
            } catch (...) {  // no memory: the error itself is what counts
            }
          }};
}

bool has_colors() {
  const char* const refused = std::getenv("NO_COLOR");
  return is_terminal(STDERR_FILENO) && (refused == nullptr || *refused == '\0');
}

Progress::Progress(const Console& console, std::string stage, std::string unit)
    : console_(console), stage_(std::move(stage)), unit_(std::move(unit)), terminal_(is_terminal(STDOUT_FILENO)) {}

/// On a terminal ten times a second, elsewhere at every tenth, and at once where it takes long.
bool Progress::is_due(double fraction, double left_s) {
  if (terminal_) {
    const double seconds = watch_.seconds();
    if (fraction < 1 && last_drawn_s_ >= 0 && seconds - last_drawn_s_ < kRedrawSeconds) return false;
    last_drawn_s_ = seconds;
    return true;
  }
  const int tenth = static_cast<int>(10 * fraction);
  const bool first_of_many = !named_ && left_s > kLongSeconds;
  if (tenth <= last_tenth_ && !first_of_many) return false;
  last_tenth_ = std::max(tenth, last_tenth_);
  named_ = true;
  return true;
}

void Progress::draw(double fraction, const std::string& text) {
  if (terminal_) {
    const std::string done(static_cast<std::size_t>(fraction * kBarCells), '#');
    const std::string bar = fmt::format("{:.<{}}", done, kBarCells);
    std::printf("\r%s [%s] %s \033[K", stage_.c_str(), bar.c_str(), text.c_str());
    open_ = true;
  } else {
    std::printf("%s %s\n", stage_.c_str(), text.c_str());
  }
  std::fflush(stdout);
}

void Progress::update(std::int64_t done, std::int64_t total) {
  if (console_.quiet || total <= 0) return;
  const double fraction = static_cast<double>(done) / static_cast<double>(total), seconds = watch_.seconds();
  const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
  const double left = rate > 0 ? static_cast<double>(total - done) / rate : 0;
  if (!is_due(fraction, left)) return;
  const std::string rate_text = rate < 10 ? fmt::format("{:.2g}", rate) : fmt::format("{:.0f}", rate);
  const char* const form = terminal_ ? "{}/{} {}  {}/s  {:.0f} s left" : "{}/{} {}, {} per second, {:.0f} s left";
  draw(fraction, fmt::format(fmt::runtime(form), done, total, unit_, rate_text, left));
}

void Progress::update_part(double fraction, const std::string& what, bool always) {
  fraction = std::clamp(fraction, 0.0, 1.0);
  const bool known = fraction >= kLeastFraction;
  const double left_s = known ? watch_.seconds() * (1 - fraction) / fraction : 0;
  if (console_.quiet || (!always && !is_due(fraction, left_s))) return;
  draw(fraction, fmt::format("{:.0f} %{}{}", 100 * fraction, what.empty() ? "" : ": " + what,
                             known ? fmt::format(", {:.0f} s left", left_s) : ""));
}

void Progress::finish() {
  if (open_) std::printf("\n");
  open_ = false;
}

void print_json(const Json& json) {
  std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

void run_with_json(const Console& console, const std::function<void(const Console&)>& work) {
  Console silent = console;
  silent.quiet = true;
  try {
    work(silent);
  } catch (const std::exception& error) {
    Json out{{"program", "reamsim " REAMSIM_VERSION}, {"ok", false}, {"mistakes", Json::array()}};
    if (const auto* input = dynamic_cast<const InputError*>(&error)) {
      for (const Mistake& mistake : input->mistakes()) out["mistakes"].push_back(json_of(mistake));
    } else {
      out["error"] = message_of(error);
    }
    print_json(out);
    throw;
  }
}

}  // namespace reamsim
