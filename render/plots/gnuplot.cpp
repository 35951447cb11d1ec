// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/printable.h"
#include "sim/base/process.h"

namespace reamsim {

namespace {

std::string on_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  const std::size_t first = text.find_first_not_of(' ');
  const std::size_t last = text.find_last_not_of(' ');
  return first == std::string::npos ? std::string("no message") : text.substr(first, last - first + 1);
}

}  // namespace

std::string gnuplot_string(const std::string& text) {
  std::string out = "'";
  for (const char c : printable(text)) {
    if (c == '\'') out += '\'';
    out += c;
  }
  return out + "'";
}

void run_gnuplot(const std::string& dir, const std::string& script, const std::string& text,
                 const std::vector<std::string>& pictures) {
  write_file(dir + "/" + script, text);
  const MemoryFile messages("the messages of gnuplot");
  pid_t child = 0;
  // -d: without the user's own settings, which could change the figures.
  const int error_number =
      spawn({.arguments = {"gnuplot", "-d", script}, .dir = dir, .err = messages.descriptor()}, child);
  if (error_number != 0) throw RunError(std::string("gnuplot cannot be started: ") + std::strerror(error_number));
  if (!succeeded(wait_for(child))) {
    throw RunError(dir + ": gnuplot failed on " + script + ": " + on_one_line(messages.contents()));
  }
  for (const std::string& name : pictures) {
    std::error_code error;
    if (std::filesystem::file_size(dir + "/" + name, error) == 0 || error) {
      throw RunError(dir + "/" + name + ": gnuplot wrote nothing: " + on_one_line(messages.contents()));
    }
  }
}

}  // namespace reamsim
