// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Part of the coverage build only. gcov writes its counters when a process ends with exit(). The children that read
// files end with _exit(), in a sandbox that lets them write nothing; here they write their counters first, and the
// sandbox lets them.

#include <seccomp.h>
#include <sys/resource.h>

extern "C" {

void __gcov_dump();
[[noreturn]] void __real__exit(int status);
int __real_setrlimit(int resource, const rlimit* limit);

[[noreturn]] void __wrap__exit(int status) {
  __gcov_dump();
  __real__exit(status);
}

int __wrap_seccomp_load(scmp_filter_ctx) {
  return 0;
}

int __wrap_setrlimit(int resource, const rlimit* limit) {
  return resource == RLIMIT_FSIZE || resource == RLIMIT_AS ? 0 : __real_setrlimit(resource, limit);
}

}  // extern "C"
