// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/output_folder.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/core.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <new>
#include <thread>

#include "sim/base/file.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr std::string_view kBegin = "reamsim ";

[[noreturn]] void refuse(const std::string& path, const std::string& found, const std::string& expected) {
  throw InputError({path, 0, 0}, "output folder", found, expected);
}

/// Whether the descriptor is still the file of this name: the process that held the lock before may have removed it.
bool is_file_of(int descriptor, const std::string& path) {
  struct stat held {
  }, named{};
  return fstat(descriptor, &held) == 0 && stat(path.c_str(), &named) == 0 && held.st_ino == named.st_ino &&
         held.st_dev == named.st_dev;
}

std::string holder_of(int descriptor) {
  std::array<char, 256> text{};
  const ssize_t got = pread(descriptor, text.data(), text.size(), 0);
  const std::string all(text.data(), static_cast<std::size_t>(got < 0 ? 0 : got));
  return all.substr(0, all.find('\n'));
}

/// The holder of a lock that another process has. That process writes its name just after it took the lock, so a file
/// without one is read again for up to a second.
std::string wait_for_holder(int descriptor) {
  std::string holder = holder_of(descriptor);
  for (int attempt = 0; attempt < 50 && holder.empty(); ++attempt) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    holder = holder_of(descriptor);
  }
  return holder.empty() ? "another run" : holder;
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "this machine";
}

namespace fs = std::filesystem;

/// Absolute, links resolved as far as the path exists, without a slash at its end.
std::string resolved(const std::string& path) {
  std::error_code error;
  fs::path out = fs::weakly_canonical(fs::absolute(path), error);
  if (error) out = fs::absolute(path).lexically_normal();
  return out.has_filename() ? out.string() : out.parent_path().string();
}

/// `dir`, whose files the other commands must be able to name in their results. Throws InputError.
const std::string& recordable(const std::string& dir) {
  if (!is_printable(dir)) refuse(dir, "is no UTF-8 on one line", "choose another name with -o");
  return dir;
}

bool is_within_folder(const std::string& path, const std::string& folder) {
  const fs::path inner(path), outer(folder);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

std::vector<std::string> homes() {
  std::vector<std::string> out{"/"};
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') out.emplace_back(home);
  if (const passwd* user = getpwuid(geteuid()); user != nullptr && user->pw_dir != nullptr) {
    out.emplace_back(user->pw_dir);
  }
  return out;
}

/// Throws InputError where `dir` holds the current folder, a home or an input.
void require_harmless(const std::string& dir, const std::vector<std::string>& inputs) {
  std::error_code error;
  const std::string choose = "choose another folder with -o";
  if (const fs::path here = fs::current_path(error); !error && is_within_folder(here.string(), dir)) {
    refuse(dir, "holds the current folder", choose);
  }
  for (const std::string& home : homes()) {
    if (is_within_folder(resolved(home), dir)) refuse(dir, "is or holds a home folder", choose);
  }
  for (const std::string& input : inputs) {
    if (is_within_folder(resolved(input), dir)) refuse(dir, "holds the input " + input, choose);
  }
}

bool is_mount_point(const std::string& dir) {
  struct statx facts {};
  if (statx(AT_FDCWD, dir.c_str(), AT_SYMLINK_NOFOLLOW, STATX_TYPE, &facts) != 0) return false;
  return (facts.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0;
}

void require_no_link(const std::string& dir) {
  if (!fs::is_symlink(dir)) return;
  refuse(dir, "is a link", "remove it, or choose another folder with -o");
}

/// Throws InputError unless `dir` holds only what a command of this kind writes. `must_be_marked`: it must also be
/// finished, or empty.
void require_ours(const std::string& dir, ResultKind kind, bool must_be_marked) {
  const std::string expected = "reamsim replaces only folders that it wrote: choose another folder with -o";
  require_no_link(dir);
  if (!fs::is_directory(dir)) refuse(dir, "is a file", "choose a folder with -o");
  if (is_mount_point(dir)) refuse(dir, "is a mount point", "choose a folder below it with -o");
  if (const auto foreign = foreign_entry(dir, kind)) refuse(dir, "holds " + *foreign, expected);
  if (must_be_marked && !fs::is_empty(dir) && !is_marked(dir, kind))
    refuse(dir, "is not a finished results folder", expected);
}

/// Renames with flags. Returns false where the file system has none of them. Throws std::system_error.
bool renamed(const std::string& from, const std::string& to, unsigned flags) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), flags) == 0) return true;
  if (errno != EINVAL && errno != ENOSYS) throw std::system_error(errno, std::generic_category());
  return false;
}

/// Moves `partial` to `dir`, atomically where the file system can, and returns the new path of the old folder.
/// Allocates nothing once a folder has moved, so that a failure leaves both where they were. Throws std::system_error.
std::string replace(const std::string& partial, const std::string& dir) {
  std::string exchanged = partial;
  if (renamed(partial, dir, RENAME_EXCHANGE)) return exchanged;
  std::string old = dir + ".old-XXXXXX";
  if (mkdtemp(old.data()) == nullptr) throw std::system_error(errno, std::generic_category());
  const fs::path from(partial), to(dir), aside(old);
  fs::rename(to, aside);
  std::error_code failed;
  fs::rename(from, to, failed);
  if (!failed) return old;
  fs::rename(aside, to);
  throw std::system_error(failed);
}

/// Removes what reamsim wrote into `dir`. Returns false where anything remains, also for want of memory.
bool removed(const std::string& dir, ResultKind kind) noexcept {
  try {
    return remove_results(dir, kind);
  } catch (const std::exception&) {  // the next command with --overwrite or --resume removes it
    return false;
  }
}

/// Creates the folders above `below` that do not exist. What it returns removes those that stay empty.
std::shared_ptr<void> create_folders_above(const std::string& below) {
  std::error_code error;
  std::vector<std::string> created;
  const std::string dir = fs::path(below).parent_path().string();
  for (fs::path at(dir); !at.empty() && !fs::exists(fs::symlink_status(at, error)); at = at.parent_path()) {
    created.push_back(at.string());
  }
  fs::create_directories(dir, error);
  if (error || !fs::is_directory(dir, error)) refuse(below, "cannot be created", "choose a writable place with -o");
  return {nullptr, [created](void*) {
            for (const std::string& each : created) rmdir(each.c_str());
          }};
}

}  // namespace

FolderLock::FolderLock(const std::string& dir) : path_(dir + ".lock") {
  while (descriptor_ < 0) {
    const int opened = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (opened < 0) refuse(path_, "cannot be created", "choose a writable place with -o");
    const std::string holder = holder_of(opened);
    if (!holder.empty() && !holder.starts_with(kBegin)) {
      close(opened);
      refuse(path_, "is not a lock of reamsim", "choose another folder with -o");
    }
    if (flock(opened, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      const std::string name = wait_for_holder(opened);
      close(opened);
      throw FolderInUse({dir, 0, 0}, "output folder", "is in use by " + name,
                        "wait until that ends, or choose another folder with -o");
    }
    if (is_file_of(opened, path_)) {
      descriptor_ = opened;
    } else {
      close(opened);
    }
  }
  const std::string text = fmt::format("{}process {} on {} since {:%Y-%m-%d %H:%M:%S}\n", kBegin, getpid(), host_name(),
                                       fmt::localtime(std::time(nullptr)));
  // Only for messages: a full disk must not prevent a run.
  if (ftruncate(descriptor_, 0) == 0 && pwrite(descriptor_, text.data(), text.size(), 0) < 0) return;
}

void FolderLock::release() {
  if (descriptor_ < 0) return;
  unlink(path_.c_str());  // before the lock is released, so that nobody else holds it
  close(descriptor_);
  descriptor_ = -1;
}

OutputFolder::OutputFolder(const OutputRequest& request)
    : kind_(request.kind),
      dir_(resolved(request.dir)),
      partial_(dir_ + ".partial"),
      overwrite_(request.overwrite),
      durable_(request.durable),
      parents_(create_folders_above(dir_)),
      lock_(recordable(dir_)) {
  std::error_code error;
  for (const std::string& place : {dir_, partial_}) {
    if (!fs::exists(fs::symlink_status(place, error))) continue;
    require_no_link(place);
    require_harmless(place, request.inputs);
    const bool resumes = request.resume && place == partial_;
    if (!overwrite_ && !resumes && place == dir_) {
      refuse(place, "exists already", "choose another with -o, or add --overwrite");
    }
    if (!overwrite_ && !resumes) {
      refuse(place, "was left by an earlier, unfinished run",
             "choose another with -o, continue that run with `reamsim run --resume`, or add --overwrite");
    }
    require_ours(place, kind_, place == dir_);
    complete_ = resumes && read_manifest(place).has_value();
  }
  request.resume ? create_partial() : clear();
}

void OutputFolder::create_partial() const {
  std::error_code error;
  fs::create_directory(partial_, error);
  if (error || !fs::is_directory(partial_, error)) {
    refuse(partial_, "cannot be created", "choose a writable place with -o");
  }
}

void OutputFolder::clear() {
  remove_results(partial_, kind_);
  create_partial();
}

OutputFolder::~OutputFolder() {
  if (!keep_) removed(partial_, kind_);
}

void OutputFolder::abandon() {
  if (!keep_ && !has_frames()) remove_results(partial_, kind_);
  lock_.release();
}

bool OutputFolder::has_frames() const {
  std::ifstream forces(partial_ + "/forces.csv", std::ios::binary);
  std::string header;
  const bool rows = std::getline(forces, header) && forces.peek() != std::ifstream::traits_type::eof();
  return rows || forces.bad();  // what cannot be read may have rows
}

std::string OutputFolder::finish(const std::function<void()>& remove_unfinished) {
  keep_ = true;  // complete, so never removed again
  // Written beforehand: where memory runs out, the message must still say where the results are.
  const std::string unlisted = "the results, without their manifest, are in " + partial_;
  const std::string unsynced = "the results are in " + partial_ + ", where a power failure may still damage them";
  const std::string complete = "the results are complete in " + partial_;
  const std::string in_place = "the results are in " + dir_ + ", but a power failure may undo that";
  const std::string safe = "the results are in " + dir_;
  // NOLINTBEGIN(clang-analyzer-deadcode.DeadStores): read after an exception
  const std::string* where = &unlisted;
  std::string why;
  try {
    list_results(partial_, kind_, {}, durable_);
    where = &unsynced;
    if (durable_) sync_folder_to_disk(partial_);
    where = &complete;
    if (remove_unfinished) remove_unfinished();
    const std::string replaced = put_in_place();
    where = &in_place;
    if (durable_) sync_to_disk(fs::path(dir_).parent_path().string());
    where = &safe;
    if (replaced.empty() || removed(replaced, kind_)) return "";
    return replaced + ": the replaced results cannot be removed; delete this folder";
  } catch (const std::system_error& error) {
    why = dir_ + ": cannot be moved into place (" + error.code().message() + ")";
  } catch (const std::runtime_error& error) {
    why = message_of(error);
  } catch (const std::bad_alloc& error) {
    why = message_of(error);
  }
  // NOLINTEND(clang-analyzer-deadcode.DeadStores)
  throw RunError(why + "; " + *where);
}

std::string OutputFolder::put_in_place() {
  if (!overwrite_ || !fs::exists(dir_)) {
    // The other way replaces nothing but an empty folder.
    if (!renamed(partial_, dir_, RENAME_NOREPLACE)) fs::rename(partial_, dir_);
    return "";
  }
  require_ours(dir_, kind_, true);  // it may have changed since
  return replace(partial_, dir_);
}

std::vector<std::string> finished_runs(const std::string& study_dir) {
  std::vector<std::string> out;
  std::error_code error;
  for (fs::directory_iterator entry(study_dir + "/runs", error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension().empty()) out.push_back(entry->path().filename().string());
  }
  std::ranges::sort(out);
  return out;
}

ResultUpdate::ResultUpdate(const std::string& dir, ResultKind kind)
    : dir_(resolved(dir)),
      kind_(kind),
      lock_(dir_.substr(0, dir_.size() - (dir_.ends_with(".partial") ? 8 : 0))),
      foreign_(open_results(dir_, kind)) {}

void ResultUpdate::finish() {
  if (read_manifest(dir_)) list_results(dir_, kind_, foreign_);
}

void require_replaceable_file(const std::string& path, const std::string& key, bool overwrite,
                              bool (*is_ours)(const std::string&), const std::vector<std::string>& inputs) {
  const auto fail = [&](const std::string& found, const std::string& expected) {
    throw InputError({path, 0, 0}, key, found, expected);
  };
  std::error_code error;
  const fs::path folder = fs::absolute(path).parent_path();
  if (!is_printable(path)) fail("is no UTF-8 on one line", "choose another name");
  if (!fs::is_directory(folder, error)) fail("there is no folder " + folder.string(), "create it, or choose another");
  if (!fs::exists(fs::symlink_status(path, error))) return;
  for (const std::string& input : inputs) {
    if (fs::equivalent(input, path, error)) fail("is an input", "choose another name");
  }
  if (fs::is_directory(path, error)) fail("is a folder", "expected the name of a file");
  if (!fs::is_regular_file(path, error)) fail("is not a file", "choose another name");
  if (!overwrite) fail("exists already", "choose another name, or add --overwrite");
  if (!is_ours(path)) fail("is not a file that reamsim wrote", "choose another name");
}

}  // namespace reamsim
