// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/paths.h"

#include <fcntl.h>
#include <poll.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include "sim/base/error.h"
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
  while (at < text.size()) {
    if (text.compare(at, 3, "$${") == 0) {
      out += "${";
      at += 3;
      continue;
    }
    if (text.compare(at, 2, "${") != 0) {
      out += text[at++];
      continue;
    }
    const std::size_t end = text.find('}', at);
    const std::string name = end == std::string::npos ? "" : text.substr(at + 2, end - at - 2);
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
  return out;
}

void require_input(const std::string& path, TextKind kind, const SourceLocation& where, const std::string& key) {
  const std::string name = shown_path(path);
  const std::string wanted = kind == TextKind::input_file ? "a file" : "a file or a folder";
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (const std::string reason = unreachable_reason(path); !reason.empty()) {
    throw InputError(where, key, name + " cannot be read (" + reason + ")",
                     "expected " + wanted + " with read permission, in folders that may be searched");
  }
  if (status.type() == fs::file_type::not_found) {
    throw InputError(where, key, "no such file: " + name, "expected " + wanted + " that exists");
  }
  const bool folder = status.type() == fs::file_type::directory;
  if (folder && kind == TextKind::input_file) {
    throw InputError(where, key, name + " is a folder", "expected " + wanted);
  }
  if (!folder && status.type() != fs::file_type::regular) {
    // It is read more than once: for its checksum, and again by --resume.
    throw InputError(where, key, name + " is a pipe, a device or a socket", "expected " + wanted + " on a disk");
  }
  if (access(path.c_str(), folder ? R_OK | X_OK : R_OK) != 0) {
    throw InputError(where, key, name + " cannot be read", "expected " + wanted + " with read permission");
  }
}

/// `path` with "${" as "$${".
std::string escape_path(const std::string& path) {
  std::string out;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path.compare(i, 2, "${") == 0) out += '$';
    out += path[i];
  }
  return out;
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
    if (path.starts_with(home)) return kHomeVariable + escape_path(path.substr(home.size()));
  }
  return escape_path(path);
}

std::string recorded_text(std::string text) {
  for (const std::string& home : home_prefixes()) {
    for (std::size_t at = 0; (at = text.find(home, at)) != std::string::npos; at += kHomeVariable.size()) {
      text.replace(at, home.size(), kHomeVariable);
    }
  }
  return text;
}

namespace {

constexpr int kPipeWait_ms = 10'000;

[[noreturn]] void refuse(const std::string& path, const std::string& found) {
  throw InputError({shown_path(path), 0, 0}, "", found, "expected a scenario file (YAML)");
}

[[noreturn]] void refuse_with_reason(const std::string& path, int error) {
  refuse(path, "cannot be read (" + std::generic_category().message(error) + ")");
}

/// A descriptor of the file.
int open_to_read(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // or it would wait for a pipe's writer
  if (file >= 0) return file;
  if (errno == ENOENT || errno == ENOTDIR) refuse(path, "no such file");
  refuse_with_reason(path, errno);
}

/// A file that is open for reading.
class OpenFile {
 public:
  explicit OpenFile(const std::string& path) : path_(path), file_(open_to_read(path)) {
    struct stat status {};
    is_pipe_ = fstat(file_, &status) == 0 && S_ISFIFO(status.st_mode);
  }
  ~OpenFile() { close(file_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  /// Reads into `text`; false at the end of the file.
  bool read_on(std::string& text) const {
    std::array<char, 65536> chunk{};
    wait_for_text();
    const ssize_t count = read(file_, chunk.data(), chunk.size());
    if (count < 0 && errno == EISDIR) refuse(path_, "is a folder");
    if (count < 0 && errno != EAGAIN && errno != EINTR) refuse_with_reason(path_, errno);
    if (count > 0) text.append(chunk.data(), static_cast<std::size_t>(count));
    return count != 0;
  }

 private:
  /// A pipe has an end only after a writer has opened it, which poll() waits for and read() does not.
  void wait_for_text() const {
    pollfd input{.fd = file_, .events = POLLIN, .revents = 0};
    if (poll(&input, 1, is_pipe_ ? kPipeWait_ms : -1) == 0)
      refuse(path_, "is a pipe into which nothing was written for 10 s");
  }

  const std::string& path_;
  int file_;
  bool is_pipe_ = false;
};

}  // namespace

std::string read_scenario_text(const std::string& path, std::size_t most_bytes) {
  const OpenFile file(path);
  std::string text;
  while (text.size() <= most_bytes && file.read_on(text)) {
  }
  return text;
}

}  // namespace reamsim
