// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/device/kernel_cache.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "sim/base/error.h"

namespace reamsim::cl {

namespace {

namespace fs = std::filesystem;

constexpr const char* kVariable = "POCL_CACHE_DIR";

struct CacheFolder {
  std::string path;
  std::string variable;  ///< that gives it
};

/// The folder that PoCL takes.
CacheFolder usual_folder() {
  const auto given = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value == nullptr ? "" : value);
  };
  if (const std::string folder = given(kVariable); !folder.empty()) return {folder, kVariable};
  if (const std::string folder = given("XDG_CACHE_HOME"); !folder.empty())
    return {folder + "/pocl/kcache", "XDG_CACHE_HOME"};
  if (const std::string folder = given("HOME"); !folder.empty()) return {folder + "/.cache/pocl/kcache", "HOME"};
  return {"/tmp/pocl/kcache", "HOME is not set"};
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

std::string make_temporary_folder() {
  std::error_code error;
  std::string tried = fs::temp_directory_path(error).string();  // TMPDIR, unless it is no folder
  for (const std::string& parent : {tried, std::string("/tmp")}) {
    std::string name = parent + "/reamsim-kernels-XXXXXX";
    if (!parent.empty() && mkdtemp(name.data()) != nullptr) return name;
  }
  return "";
}

}  // namespace

KernelCache::KernelCache() {
  const CacheFolder usual = usual_folder();
  if (is_writable(usual.path)) return;
  const std::string found = usual.path + " (" + usual.variable + ") cannot be written";
  temporary_ = make_temporary_folder();
  if (temporary_.empty()) {
    throw InputError({}, kVariable, found + ", nor can TMPDIR or /tmp",
                     "set it to a writable folder, where OpenCL keeps compiled kernels");
  }
  setenv(kVariable, temporary_.c_str(), 1);
  warning_ = found + "; kernels are compiled in each run: set " + kVariable + " to a writable folder";
}

KernelCache::~KernelCache() {
  if (temporary_.empty()) return;
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
}

}  // namespace reamsim::cl
