// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>  // defines __GLIBC__
#include <fstream>

#include "sim/base/text.h"
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace reamsim {

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

std::string address_space_note() {
  const auto limit = address_space_limit();
  return limit ? "the address space is limited to " + megabytes(*limit) + " (ulimit -v)" : "";
}

}  // namespace reamsim
