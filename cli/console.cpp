#include "cli/console.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "sim/base/printable.h"

namespace reamsim {

namespace {

constexpr int kBarCells = 30;
constexpr double kRedrawSeconds = 0.1;

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
  std::fprintf(stderr, "reamsim: warning: %s\n", printable(line).c_str());
}

void Console::print(Report& report) const {
  if (verbose) {
    for (const auto& note : report.notes) say("  " + note);
  }
  for (const auto& warning : report.warnings) warn(warning);
  for (const auto& listing : report.listings) std::fprintf(stderr, "reamsim: %s\n", printable(listing).c_str());
  report = {};
}

Progress::Progress(const Console& console, std::string stage, std::string unit)
    : console_(console), stage_(std::move(stage)), unit_(std::move(unit)), terminal_(isatty(STDOUT_FILENO) == 1) {}

void Progress::update(std::int64_t done, std::int64_t total) {
  if (console_.quiet || total <= 0) return;
  const double fraction = static_cast<double>(done) / static_cast<double>(total), seconds = watch_.seconds();
  const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
  const std::string rate_text = rate < 10 ? fmt::format("{:.2g}", rate) : fmt::format("{:.0f}", rate);
  const double left = rate > 0 ? static_cast<double>(total - done) / rate : 0;
  const auto d = static_cast<long long>(done), t = static_cast<long long>(total);
  if (terminal_) {
    if (done < total && seconds - last_drawn_s_ < kRedrawSeconds) return;
    last_drawn_s_ = seconds;
    const int cells = static_cast<int>(fraction * kBarCells);
    const std::string bar = std::string(static_cast<std::size_t>(cells), '#') +
                            std::string(static_cast<std::size_t>(kBarCells - cells), '.');
    std::printf("\r%s [%s] %lld/%lld %s  %s/s  %.0f s left \033[K", stage_.c_str(), bar.c_str(), d, t, unit_.c_str(),
                rate_text.c_str(), left);
    std::fflush(stdout);
    open_ = true;
    return;
  }
  const int tenth = static_cast<int>(10 * fraction);
  if (tenth <= last_tenth_) return;
  last_tenth_ = tenth;
  std::printf("%s %lld/%lld %s, %s per second, %.0f s left\n", stage_.c_str(), d, t, unit_.c_str(), rate_text.c_str(),
              left);
  std::fflush(stdout);
}

void Progress::finish() {
  if (open_) std::printf("\n");
  open_ = false;
}

}  // namespace reamsim
