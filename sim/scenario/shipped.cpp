// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/shipped.h"

#include <dlfcn.h>
#include <fmt/ranges.h>
#include <link.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <system_error>

#include "sim/scenario/show.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

/// Places of the shipped folders, from the folder of own_file(): an install prefix with bin/reamsim, a checkout with
/// build/NAME/cli and build/NAME/python, beside the program, and a prefix with
/// lib/python3/dist-packages/reamsim/_simulation.so.
constexpr std::array kPlaces{"../share/reamsim", "../../..", ".", "../../../../share/reamsim"};

/// The file that holds this code: the executable, or a module that it loaded. "" where that is unknown.
fs::path own_file() {
  static const char here = 0;
  Dl_info info{};
  void* found = nullptr;
  std::error_code error;
  const bool known = dladdr1(&here, &info, &found, RTLD_DL_LINKMAP) != 0 && found != nullptr;
  const std::string module = known ? static_cast<const link_map*>(found)->l_name : "";  // "": the executable
  return fs::canonical(module.empty() ? "/proc/self/exe" : module, error);
}

std::string folder_of(ShippedKind kind) {
  const std::string scenarios = shipped_folder("trajectories");
  return scenarios.empty() || kind == ShippedKind::scenario ? scenarios : scenarios + "/studies";
}

const char* text_of(ShippedKind kind) {
  return kind == ShippedKind::scenario ? "scenario" : "study";
}

/// A word that is no path of something that exists in `folder`.
bool is_missing_word(const std::string& argument, const std::string& folder) {
  std::error_code ignored;
  return !argument.empty() && argument.find('/') == std::string::npos &&
         fs::symlink_status(fs::path(folder) / argument, ignored).type() == fs::file_type::not_found;
}

/// A word that could be a name, and is no path of something that exists in `folder`.
bool may_be_name(const std::string& argument, const std::string& folder = "") {
  return !is_scenario_name(argument) && is_missing_word(argument, folder);
}

/// The file of this name, or "".
std::string file_of(const std::string& name, ShippedKind kind) {
  const std::vector<std::string> names = shipped_names(kind);
  return std::ranges::find(names, name) == names.end() ? "" : folder_of(kind) + "/" + name + ".yaml";
}

std::string no_such_name(ShippedKind kind) {
  return fmt::format("no such file, and no shipped {} of this name", text_of(kind));
}

std::string list_of(const std::vector<std::string>& names) {
  return fmt::format("expected a file (YAML) or one of {}", fmt::join(names, ", "));
}

[[noreturn]] void refuse(const std::string& name, ShippedKind kind, const std::vector<std::string>& names) {
  const ShippedKind other = kind == ShippedKind::scenario ? ShippedKind::study : ShippedKind::scenario;
  const SourceLocation where{shown_path(name), 0, 0};
  if (!file_of(name, other).empty()) {
    throw InputError(where, "", fmt::format("is a shipped {}, not a {}", text_of(other), text_of(kind)),
                     kind == ShippedKind::scenario ? "use reamsim sweep" : "use reamsim run");
  }
  throw InputError(where, "", no_such_name(kind), list_of(names));
}

/// Refuses "default.yaml" where there is no such file in `folder`, but a shipped name without the ending.
void refuse_name_with_ending(const std::string& argument, const std::string& folder, ShippedKind kind,
                             const SourceLocation& where, const std::string& key) {
  if (!is_scenario_name(argument) || !is_missing_word(argument, folder)) return;
  const fs::path path(argument);
  const std::string name = path.stem().string();
  if (file_of(name, kind).empty()) return;
  throw InputError(where, key, key.empty() ? "no such file" : "no such file: " + shown_path(argument),
                   fmt::format("use `{}` (without {}), the shipped {}, or give a file that exists", name,
                               path.extension().string(), text_of(kind)));
}

/// The same for an argument of the command line.
void refuse_name_with_ending(const std::string& argument, ShippedKind kind) {
  refuse_name_with_ending(argument, "", kind, {shown_path(argument), 0, 0}, "");
}

}  // namespace

std::string shipped_folder(const std::string& name) {
  const fs::path own = own_file().parent_path();
  if (own.empty()) return "";
  std::error_code error;
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

bool is_scenario_name(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending == ".yaml" || ending == ".yml";
}

std::string shipped_or_path(const std::string& argument, ShippedKind kind) {
  refuse_name_with_ending(argument, kind);
  if (!may_be_name(argument)) return argument;
  const std::vector<std::string> names = shipped_names(kind);
  if (names.empty()) return argument;
  const std::string file = file_of(argument, kind);
  if (file.empty()) refuse(argument, kind, names);
  return file;
}

std::string shipped_scenario_or_path(const std::string& argument) {
  refuse_name_with_ending(argument, ShippedKind::scenario);
  const std::string file = may_be_name(argument) ? file_of(argument, ShippedKind::scenario) : "";
  return file.empty() ? argument : file;
}

std::string shipped_scenario_of_key(const std::string& text, const std::string& folder, const SourceLocation& where,
                                    const std::string& key) {
  if (text.find('$') != std::string::npos) return text;  // ${NAME} becomes a path
  refuse_name_with_ending(text, folder, ShippedKind::scenario, where, key);
  if (!may_be_name(text, folder)) return text;
  const std::vector<std::string> names = shipped_names(ShippedKind::scenario);
  if (names.empty()) return text;
  const std::string file = file_of(text, ShippedKind::scenario);
  if (file.empty())
    throw InputError(where, key, shown_path(text) + ": " + no_such_name(ShippedKind::scenario), list_of(names));
  return file;
}

}  // namespace reamsim
