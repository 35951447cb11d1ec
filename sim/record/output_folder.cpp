#include "sim/record/output_folder.h"

#include <filesystem>

#include "sim/base/error.h"

namespace reamsim {

namespace fs = std::filesystem;

namespace {

/// A forces.csv longer than this holds rows, not only its header.
constexpr std::uintmax_t kHeaderBytes = 1024;

std::string without_trailing_slash(const std::string& dir) {
  const fs::path path = fs::absolute(dir).lexically_normal();
  return path.has_filename() ? path.string() : path.parent_path().string();
}

}  // namespace

OutputFolder::OutputFolder(const std::string& dir, bool overwrite)
    : dir_(without_trailing_slash(dir)), partial_(dir_ + ".partial"), overwrite_(overwrite) {
  std::error_code error;
  if (fs::exists(dir_, error) && !overwrite) {
    throw InputError({dir_, 0, 0}, "output folder", "exists already", "choose another with -o, or add --overwrite");
  }
  if (fs::exists(dir_, error) && !fs::is_directory(dir_, error)) {
    throw InputError({dir_, 0, 0}, "output folder", "is a file", "choose a folder with -o");
  }
  if (fs::exists(partial_, error) && !overwrite) {
    throw InputError({partial_, 0, 0}, "output folder", "is left from an earlier, unfinished run",
                     "remove it, choose another with -o, or add --overwrite");
  }
  fs::remove_all(partial_, error);
  fs::create_directories(partial_, error);
  if (error || !fs::is_directory(partial_, error)) {
    throw InputError({partial_, 0, 0}, "output folder", "cannot be made", "choose a writable place with -o");
  }
}

OutputFolder::~OutputFolder() {
  if (keep_) return;
  std::error_code ignored;
  fs::remove_all(partial_, ignored);
}

bool OutputFolder::has_frames() const {
  std::error_code missing;
  const auto size = fs::file_size(partial_ + "/forces.csv", missing);
  return !missing && size > kHeaderBytes;
}

void OutputFolder::finish() {
  std::error_code error;
  const std::string old = dir_ + ".old";
  const bool replaces = overwrite_ && fs::exists(dir_, error);
  if (replaces) fs::rename(dir_, old, error);
  if (!error) fs::rename(partial_, dir_, error);
  if (error) throw RunError(dir_ + ": cannot put the finished results there (" + error.message() + ")");
  keep_ = true;
  if (replaces) fs::remove_all(old, error);
}

}  // namespace reamsim
