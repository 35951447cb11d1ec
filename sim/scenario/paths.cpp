// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/paths.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/ranges.h>
#include <link.h>
#include <poll.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

const std::string kHomeVariable = "${HOME}/";

bool is_variable_name(const std::string& name) {
  return !name.empty() &&
         name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
}

/// The user's home as the environment has it, else as the system has it, or "".
std::string home_folder() {
  const char* variable = std::getenv("HOME");
  if (variable != nullptr && *variable != '\0') return variable;
  const passwd* user = getpwuid(geteuid());
  return user != nullptr && user->pw_dir != nullptr ? user->pw_dir : "";
}

/// The home with a slash at its end, as it is named and with links resolved. Empty if it is not the folder of a user.
std::vector<std::string> home_prefixes() {
  const fs::path home = fs::path(home_folder() + "/").lexically_normal();
  if (!home.is_absolute() || !home.has_relative_path()) return {};
  std::error_code error;
  const std::string real = fs::weakly_canonical(home, error).string();
  if (error || real.empty() || real == "/") return {home.string()};
  return {home.string(), real.back() == '/' ? real : real + "/"};
}

std::string value_of(const std::string& variable) {
  if (variable == "HOME") return home_folder();
  const char* value = std::getenv(variable.c_str());
  return value == nullptr ? "" : value;
}

std::string expand_variables(const std::string& text, const SourceLocation& where, const std::string& key) {
  std::string out;
  std::size_t at = 0;
  for (std::size_t begin = 0; (begin = text.find("${", at)) != std::string::npos;) {
    out += text.substr(at, begin - at);
    if (begin > at && text[begin - 1] == '$') {
      out += "{";
      at = begin + 2;
      continue;
    }
    const std::size_t end = text.find('}', begin);
    const std::string name = end == std::string::npos ? "" : text.substr(begin + 2, end - begin - 2);
    if (!is_variable_name(name)) {
      throw InputError(where, key, "found " + shown_text(text),
                       "expected ${NAME} with the name of a variable, or $${ "
                       "for the characters ${");
    }
    const std::string value = value_of(name);
    if (value.empty()) {
      throw InputError(where, key, "the environment variable " + name + " in " + shown_text(text) + " is not set",
                       "expected it to name a folder or file (export " + name + "=...)");
    }
    out += value;
    at = end + 1;
  }
  return out + text.substr(at);
}

void require_input(const std::string& path, TextKind kind, const SourceLocation& where, const std::string& key) {
  const std::string name = shown_path(path);
  const std::string expected = kind == TextKind::input_file ? "expected a file" : "expected a file or a folder";
  const auto refuse = [&](const std::string& found, const char* more) {
    throw InputError(where, key, found, expected + more);
  };
  std::error_code error;
  const fs::file_type type = fs::status(path, error).type();
  if (const std::string reason = unreachable_reason(path); !reason.empty())
    refuse(name + " cannot be read (" + reason + ")", " with read permission, in folders that may be searched");
  if (type == fs::file_type::not_found) refuse("no such file: " + name, " that exists");
  const bool folder = type == fs::file_type::directory;
  if (folder && kind == TextKind::input_file) refuse(name + " is a folder", "");
  // It is read more than once: for its checksum, and again by --resume.
  if (!folder && type != fs::file_type::regular) refuse(name + " is a pipe, a device or a socket", " on a disk");
  if (access(path.c_str(), folder ? R_OK | X_OK : R_OK) != 0) refuse(name + " cannot be read", " with read permission");
}

constexpr int kPipeWait_ms = 10'000;

[[noreturn]] void refuse(const std::string& path, const std::string& found) {
  refuse_file(shown_path(path), found, "expected a scenario file (YAML)");
}

[[noreturn]] void refuse_with_reason(const std::string& path, int error) {
  refuse(path, "cannot be read (" + std::generic_category().message(error) + ")");
}

/// A descriptor of a file that is open for reading.
struct OpenFile {
  // Without O_NONBLOCK it would wait for a pipe's writer.
  explicit OpenFile(const std::string& path) : descriptor(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    if (descriptor >= 0) return;
    if (errno == ENOENT || errno == ENOTDIR) refuse(path, "no such file");
    refuse_with_reason(path, errno);
  }
  ~OpenFile() { close(descriptor); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  int descriptor;
};

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

/// The file of this name, or "".
std::string file_of(const std::string& name, ShippedKind kind) {
  const std::vector<std::string> names = shipped_names(kind);
  if (std::ranges::find(names, name) == names.end()) return "";
  return (name.find('/') == std::string::npos ? folder_of(kind) : shipped_folder("trajectories")) + "/" + name +
         ".yaml";
}

/// Where a text stands that may be a name.
struct Place {
  SourceLocation where;
  std::string key = "";     ///< "": an argument
  std::string folder = "";  ///< of relative paths
};

[[noreturn]] void refuse_unknown(const std::string& name, ShippedKind kind, const Place& place) {
  const ShippedKind other = kind == ShippedKind::scenario ? ShippedKind::study : ShippedKind::scenario;
  if (place.key.empty() && !file_of(name, other).empty()) {
    throw InputError(place.where, "", fmt::format("is a shipped {}, not a {}", name_of(other), name_of(kind)),
                     kind == ShippedKind::scenario ? "use reamsim sweep" : "use reamsim run");
  }
  const std::string found = place.key.empty() ? "" : shown_path(name) + ": ";
  throw InputError(place.where, place.key,
                   fmt::format("{}no such file, and no shipped {} of this name", found, name_of(kind)),
                   fmt::format("expected a file (YAML) or one of {}", fmt::join(shipped_names(kind), ", ")));
}

/// The shipped file that a text names, or the text where it is a path: it exists in the folder or has a slash. Refuses
/// "default.yaml" where there is no such file, but a shipped name without the ending. Without shipped files, and with
/// `may_be_other`, an unknown name is a path as well.
std::string file_meant(const std::string& text, ShippedKind kind, const Place& place, bool may_be_other) {
  const fs::path path(text);
  std::error_code ignored;
  const bool is_word = !text.empty() && (text.find('/') == std::string::npos || !file_of(text, kind).empty()) &&
                       fs::symlink_status(place.folder / path, ignored).type() == fs::file_type::not_found;
  if (!is_word) return text;
  if (!is_scenario_name(text)) {
    const std::string file = file_of(text, kind);
    if (file.empty() && !may_be_other && !shipped_names(kind).empty()) refuse_unknown(text, kind, place);
    return file.empty() ? text : file;
  }
  const std::string name = path.stem().string();
  if (file_of(name, kind).empty()) return text;
  throw InputError(place.where, place.key, "no such file" + (place.key.empty() ? "" : ": " + shown_path(text)),
                   fmt::format("use `{}` (without {}), the shipped {}, or give a file that exists", name,
                               path.extension().string(), name_of(kind)));
}

}  // namespace

void require_recordable(const std::string& path, const SourceLocation& where, const std::string& key) {
  if (is_printable(path)) return;
  throw InputError(where, key, "found the path " + shown_path(path),
                   "rename it: expected UTF-8 without line breaks or control characters");
}

std::string resolve_path(const std::string& text, TextKind kind, const std::string& folder, const SourceLocation& where,
                         const std::string& key) {
  if (text.empty()) return text;
  const fs::path path = fs::path(folder) / expand_variables(text, where, key);
  std::string absolute = path.lexically_normal().string();
  require_recordable(absolute, where, key);
  if (absolute.size() > 1 && absolute.back() == '/') absolute.pop_back();
  if (kind != TextKind::output_folder) require_input(absolute, kind, where, key);
  return absolute;
}

std::string recorded_path(const std::string& path) {
  for (const std::string& home : home_prefixes()) {
    if (path.starts_with(home)) return kHomeVariable + replace_all(path.substr(home.size()), {{"${", "$${"}});
  }
  return replace_all(path, {{"${", "$${"}});
}

std::string recorded_text(std::string text) {
  for (const std::string& home : home_prefixes()) text = replace_all(text, {{home, kHomeVariable}});
  return text;
}

std::string read_scenario_text(const std::string& path, std::size_t most_bytes) {
  const OpenFile file(path);
  struct stat status {};
  const bool is_pipe = fstat(file.descriptor, &status) == 0 && S_ISFIFO(status.st_mode);
  std::array<char, 65536> chunk{};
  std::string text;
  while (text.size() <= most_bytes) {
    // A pipe has an end only after a writer has opened it, which poll() waits for and read() does not.
    pollfd input{.fd = file.descriptor, .events = POLLIN, .revents = 0};
    if (poll(&input, 1, is_pipe ? kPipeWait_ms : -1) == 0)
      refuse(path, "is a pipe into which nothing was written for 10 s");
    const ssize_t count = read(file.descriptor, chunk.data(), chunk.size());
    if (count == 0) break;
    if (count > 0) text.append(chunk.data(), static_cast<std::size_t>(count));
    if (count < 0 && errno == EISDIR) refuse(path, "is a folder");
    if (count < 0 && errno != EAGAIN && errno != EINTR) refuse_with_reason(path, errno);
  }
  return text;
}

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
  const auto add = [&](const std::string& folder, const std::string& prefix, const char* beside) {
    std::error_code error;  // a folder that cannot be read has no names
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
      fs::path file = entry->path();
      if (file.extension() != ".yaml" || !fs::exists(file.replace_extension(beside), error)) continue;
      names.push_back(prefix + file.stem().string());
    }
  };
  add(folder_of(kind), "", ".yaml");
  // The base scenarios of validations have no published numbers.
  if (kind == ShippedKind::study) add(shipped_folder("trajectories/validation"), "validation/", ".csv");
  std::ranges::sort(names);
  return names;
}

bool is_scenario_name(const std::string& path) {
  const std::string ending = lower_case(fs::path(path).extension().string());
  return ending == ".yaml" || ending == ".yml";
}

std::string shipped_or_path(const std::string& argument, ShippedKind kind) {
  return file_meant(argument, kind, {{shown_path(argument), 0, 0}}, false);
}

std::string shipped_scenario_or_path(const std::string& argument) {
  return file_meant(argument, ShippedKind::scenario, {{shown_path(argument), 0, 0}}, true);
}

std::string shipped_scenario_of_key(const std::string& text, const std::string& folder, const SourceLocation& where,
                                    const std::string& key) {
  if (text.find('$') != std::string::npos) return text;  // ${NAME} becomes a path
  return file_meant(text, ShippedKind::scenario, {where, key, folder}, false);
}

}  // namespace reamsim
