// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "sim/base/error.h"
#include "sim/device/opencl.h"

namespace reamsim::cl {

namespace {

namespace fs = std::filesystem;

constexpr const char* kVariable = "POCL_CACHE_DIR";

struct CacheFolder {
  std::string path;
  std::string variable;  ///< that gives it
};

/// The folder that PoCL takes; no path where that is /tmp/pocl, which anybody may have made, with code in it.
CacheFolder usual_folder() {
  using Place = std::pair<const char*, const char*>;
  for (const auto& [variable, below] :
       {Place{kVariable, ""}, Place{"XDG_CACHE_HOME", "/pocl/kcache"}, Place{"HOME", "/.cache/pocl/kcache"}}) {
    const char* value = std::getenv(variable);
    if (value != nullptr && *value != '\0') return {std::string(value) + below, variable};
  }
  return {"", "HOME"};
}

/// Whether a file can be made in the folder, which is created. Permissions do not say so of /proc, or for root.
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

/// A folder, perhaps of an earlier run, that only this user can have filled, and can write; "": impossible.
std::string private_folder(const std::string& parent) {
  const std::string name = parent + "/reamsim-kernels-" + std::to_string(geteuid());
  if (mkdir(name.c_str(), S_IRWXU) != 0 && errno != EEXIST) return "";
  struct stat status {};
  const bool own = lstat(name.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == geteuid() &&
                   (status.st_mode & (S_IRWXG | S_IRWXO)) == 0;
  return own && is_writable(name) ? name : "";
}

}  // namespace

KernelCache::KernelCache() {
  const CacheFolder usual = usual_folder();
  if (!usual.path.empty() && is_writable(usual.path)) return;
  std::string folder;
  std::error_code error;
  const std::string variable = fs::temp_directory_path(error).string();  // TMPDIR, unless it is no folder
  for (const std::string& parent : {variable.empty() ? "/tmp" : variable, std::string("/tmp")}) {
    folder = private_folder(parent);
    std::string name = parent + "/reamsim-kernels-XXXXXX";  // where the name of private_folder() is taken
    if (folder.empty() && mkdtemp(name.data()) != nullptr) folder = temporary_ = name;
    if (!folder.empty()) break;
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
