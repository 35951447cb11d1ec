// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/device/kernel_cache.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "sim/base/error.h"

namespace reamsim::cl {

namespace {

namespace fs = std::filesystem;

constexpr const char* kVariable = "POCL_CACHE_DIR";

struct CacheFolder {
  std::string path;
  std::string variable;  ///< that gives it
};

/// The folder that PoCL takes; without a path where it would take /tmp/pocl, which anybody may have made, with code in
/// it.
CacheFolder usual_folder() {
  const auto given = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value == nullptr ? "" : value);
  };
  if (const std::string folder = given(kVariable); !folder.empty()) return {folder, kVariable};
  if (const std::string folder = given("XDG_CACHE_HOME"); !folder.empty())
    return {folder + "/pocl/kcache", "XDG_CACHE_HOME"};
  if (const std::string folder = given("HOME"); !folder.empty()) return {folder + "/.cache/pocl/kcache", "HOME"};
  return {"", "HOME"};
}

/// Whether a file can be made in the folder, which is created. Permissions alone do not say so: /proc, or a read-only
/// file system for root.
bool is_writable(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  std::string name = folder + "/reamsim-XXXXXX";
  const int file = mkstemp(name.data());
  if (file < 0) return false;
  close(file);
  unlink(name.c_str());
  return true;
}

std::vector<std::string> temporary_places() {
  std::error_code error;
  const std::string variable = fs::temp_directory_path(error).string();  // TMPDIR, unless it is no folder
  return variable.empty() || variable == "/tmp" ? std::vector<std::string>{"/tmp"}
                                                : std::vector<std::string>{variable, "/tmp"};
}

/// A folder that only this user can have filled, and can write; it may be there from an earlier run. "" if it cannot
/// be.
std::string private_folder(const std::string& parent) {
  const std::string name = parent + "/reamsim-kernels-" + std::to_string(geteuid());
  if (mkdir(name.c_str(), S_IRWXU) != 0 && errno != EEXIST) return "";
  struct stat status {};
  const bool own = lstat(name.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == geteuid() &&
                   (status.st_mode & (S_IRWXG | S_IRWXO)) == 0;
  return own && is_writable(name) ? name : "";
}

/// A new folder, where the name of private_folder() is taken.
std::string new_folder(const std::string& parent) {
  std::string name = parent + "/reamsim-kernels-XXXXXX";
  return mkdtemp(name.data()) != nullptr ? name : "";
}

}  // namespace

KernelCache::KernelCache() {
  const CacheFolder usual = usual_folder();
  if (!usual.path.empty() && is_writable(usual.path)) return;
  std::string folder;
  for (const std::string& parent : temporary_places()) {
    if (folder.empty()) folder = private_folder(parent);
    if (folder.empty()) folder = temporary_ = new_folder(parent);
  }
  const std::string found =
      usual.path.empty() ? usual.variable + " is not set" : usual.path + " (" + usual.variable + ") cannot be written";
  if (folder.empty()) {
    throw InputError({}, kVariable, found + ", and TMPDIR and /tmp cannot be written",
                     "set it to a writable folder, where OpenCL keeps compiled kernels");
  }
  setenv(kVariable, folder.c_str(), 1);
  note_ = found + "; compiled kernels are in " + folder + ": set " + kVariable + " for another folder";
}

KernelCache::~KernelCache() {
  if (temporary_.empty()) return;
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
}

}  // namespace reamsim::cl
