#include "sim/scenario/paths.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "sim/scenario/show.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

bool is_variable_name(const std::string& name) {
  return !name.empty() &&
         name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
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
    const char* value = std::getenv(name.c_str());
    if (value == nullptr || *value == '\0') {
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

}  // namespace

std::string resolve_path(const std::string& text, TextKind kind, const std::string& folder, const SourceLocation& where,
                         const std::string& key) {
  if (text.empty()) return text;
  const fs::path path = fs::path(folder) / expand_variables(text, where, key);
  std::string absolute = path.lexically_normal().string();
  const auto is_control = [](char c) { return (c >= 0 && c < 0x20) || c == 0x7f; };
  if (std::ranges::any_of(absolute, is_control)) {
    throw InputError(where, key, "found the path " + shown_path(absolute), "expected one without control characters");
  }
  if (absolute.size() > 1 && absolute.back() == '/') absolute.pop_back();
  if (kind != TextKind::output_folder) require_input(absolute, kind, where, key);
  return absolute;
}

std::string escape_path(const std::string& path) {
  std::string out;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path.compare(i, 2, "${") == 0) out += '$';
    out += path[i];
  }
  return out;
}

}  // namespace reamsim
