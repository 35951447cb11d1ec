// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/process.h"

#include <fcntl.h>
#include <malloc.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <cstdlib>  // defines __GLIBC__
#include <cstring>
#include <fstream>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

MemoryFile::MemoryFile(const std::string& purpose) : descriptor_(memfd_create("reamsim", MFD_CLOEXEC)) {
  if (descriptor_ < 0) throw RunError("no memory for " + purpose + ": " + std::strerror(errno));
}

MemoryFile::~MemoryFile() {
  close(descriptor_);
}

std::string MemoryFile::contents() const {
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t got; (got = pread(descriptor_, buffer.data(), buffer.size(), static_cast<off_t>(text.size()))) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(got));
  }
  return text;
}

int spawn(ChildCommand command, pid_t& child) {
  std::vector<char*> arguments;
  for (std::string& argument : command.arguments) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (!command.dir.empty()) posix_spawn_file_actions_addchdir_np(&actions, command.dir.c_str());
  for (const auto& [from, to] : {std::pair(command.in, STDIN_FILENO), std::pair(command.out, STDOUT_FILENO),
                                 std::pair(command.err, STDERR_FILENO)}) {
    if (from >= 0) {
      posix_spawn_file_actions_adddup2(&actions, from, to);
    } else {
      posix_spawn_file_actions_addopen(&actions, to, "/dev/null", to == STDIN_FILENO ? O_RDONLY : O_WRONLY, 0);
    }
  }
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);  // this process may block signals that are to end the program
  posix_spawnattr_setpgroup(&attributes, 0);
  const int own_group = command.own_group ? POSIX_SPAWN_SETPGROUP : 0;
  posix_spawnattr_setflags(&attributes, static_cast<short>(POSIX_SPAWN_SETSIGMASK | own_group));
  const int error = posix_spawnp(&child, arguments[0], &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

int wait_for(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

bool succeeded(int status) {
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void return_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

std::optional<std::uint64_t> address_space_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return limit.rlim_cur;
}

std::uint64_t address_space_in_use() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
}

std::string address_space_note(const std::string& before, const std::string& after) {
  const auto limit = address_space_limit();
  return limit ? before + "the address space is limited to " + megabytes(*limit) + " (ulimit -v)" + after : "";
}

}  // namespace reamsim
