// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/shipped.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <system_error>

#include "cli/input_kind.h"
#include "sim/base/error.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

/// Places of the shipped folders, from the folder of the executable: an install prefix, BUILD/cli of a checkout with
/// build/NAME, and beside the program.
constexpr const char* kPlaces[] = {"../share/reamsim", "../../..", "."};

std::string folder_of(ShippedKind kind) {
  const std::string scenarios = shipped_folder("trajectories");
  return scenarios.empty() || kind == ShippedKind::scenario ? scenarios : scenarios + "/studies";
}

const char* text_of(ShippedKind kind) {
  return kind == ShippedKind::scenario ? "scenario" : "study";
}

/// A word that could be a name, and is no path of something that exists.
bool may_be_name(const std::string& argument) {
  std::error_code ignored;
  return !argument.empty() && argument.find('/') == std::string::npos && !is_scenario_name(argument) &&
         fs::symlink_status(argument, ignored).type() == fs::file_type::not_found;
}

/// The file of this name; "" where there is none.
std::string file_of(const std::string& name, ShippedKind kind) {
  const std::vector<std::string> names = shipped_names(kind);
  return std::ranges::find(names, name) == names.end() ? "" : folder_of(kind) + "/" + name + ".yaml";
}

[[noreturn]] void refuse(const std::string& name, ShippedKind kind, const std::vector<std::string>& names) {
  const ShippedKind other = kind == ShippedKind::scenario ? ShippedKind::study : ShippedKind::scenario;
  const SourceLocation where{shown_path(name), 0, 0};
  if (!file_of(name, other).empty()) {
    throw InputError(where, "", fmt::format("is a shipped {}, not a {}", text_of(other), text_of(kind)),
                     kind == ShippedKind::scenario ? "use reamsim sweep" : "use reamsim run");
  }
  throw InputError(where, "", fmt::format("no such file, and no shipped {} of this name", text_of(kind)),
                   fmt::format("expected a file (YAML) or one of {}", fmt::join(names, ", ")));
}

}  // namespace

std::string shipped_folder(const std::string& name) {
  std::error_code error;
  const fs::path own = fs::read_symlink("/proc/self/exe", error).parent_path();
  if (error) return "";
  for (const char* place : kPlaces) {
    const fs::path folder = (own / place / name).lexically_normal();
    if (fs::is_directory(folder, error)) return folder.string();
  }
  return "";
}

std::vector<std::string> shipped_names(ShippedKind kind) {
  std::vector<std::string> names;
  std::error_code error;  // a folder that cannot be read has no names
  for (fs::directory_iterator entry(folder_of(kind), error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension() == ".yaml") names.push_back(entry->path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

std::string shipped_or_path(const std::string& argument, ShippedKind kind) {
  if (!may_be_name(argument)) return argument;
  const std::vector<std::string> names = shipped_names(kind);
  if (names.empty()) return argument;
  const std::string file = file_of(argument, kind);
  if (file.empty()) refuse(argument, kind, names);
  return file;
}

std::string shipped_scenario_or_path(const std::string& argument) {
  const std::string file = may_be_name(argument) ? file_of(argument, ShippedKind::scenario) : "";
  return file.empty() ? argument : file;
}

void take_shipped_names(CLI::Option& option, ShippedKind kind) {
  option.transform([kind](const std::string& argument) { return shipped_or_path(argument, kind); }, "");
}

}  // namespace reamsim
