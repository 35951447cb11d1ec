// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/folder_lock.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <thread>

#include "sim/base/error.h"

namespace reamsim {

namespace {

constexpr std::string_view kBegin = "reamsim ";

[[noreturn]] void refuse_lock(const std::string& path, const std::string& found, const std::string& expected) {
  throw InputError({path, 0, 0}, "output folder", found, expected);
}

/// Whether the descriptor is still the file of this name: the process that held the lock before may have removed it.
bool is_file_of(int descriptor, const std::string& path) {
  struct stat held {
  }, named{};
  return fstat(descriptor, &held) == 0 && stat(path.c_str(), &named) == 0 && held.st_ino == named.st_ino &&
         held.st_dev == named.st_dev;
}

/// The first line of a lock.
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

}  // namespace

FolderLock::FolderLock(const std::string& dir) : path_(dir + ".lock") {
  while (descriptor_ < 0) {
    const int opened = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (opened < 0) refuse_lock(path_, "cannot be created", "choose a writable place with -o");
    const std::string holder = holder_of(opened);
    if (!holder.empty() && !holder.starts_with(kBegin)) {
      close(opened);
      refuse_lock(path_, "is not a lock of reamsim", "choose another folder with -o");
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
  describe_holder();
}

FolderLock::~FolderLock() {
  release();
}

void FolderLock::release() {
  if (descriptor_ < 0) return;
  unlink(path_.c_str());  // before the lock is released, so that nobody else holds it
  close(descriptor_);
  descriptor_ = -1;
}

void FolderLock::describe_holder() const {
  const std::string text = fmt::format("{}process {} on {} since {:%Y-%m-%d %H:%M:%S}\n", kBegin, getpid(), host_name(),
                                       fmt::localtime(std::time(nullptr)));
  // Only for messages: a full disk must not prevent a run.
  if (ftruncate(descriptor_, 0) == 0 && pwrite(descriptor_, text.data(), text.size(), 0) < 0) return;
}

}  // namespace reamsim
