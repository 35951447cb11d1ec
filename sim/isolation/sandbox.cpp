// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/isolation/sandbox.h"

#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <memory>

#include "sim/base/process.h"

namespace reamsim {

namespace {

constexpr int kOpenFiles = 32;

/// Calls that reading a file, allocating memory and ending the process need.
constexpr std::array kAllowed{
    SCMP_SYS(access),          SCMP_SYS(brk),          SCMP_SYS(clock_gettime), SCMP_SYS(clock_nanosleep),
    SCMP_SYS(close),           SCMP_SYS(dup),          SCMP_SYS(exit),          SCMP_SYS(exit_group),
    SCMP_SYS(faccessat),       SCMP_SYS(faccessat2),   SCMP_SYS(fadvise64),     SCMP_SYS(fstat),
    SCMP_SYS(fstatfs),         SCMP_SYS(futex),        SCMP_SYS(getcwd),        SCMP_SYS(getdents64),
    SCMP_SYS(getpid),          SCMP_SYS(getppid),      SCMP_SYS(getrandom),     SCMP_SYS(getrusage),
    SCMP_SYS(gettid),          SCMP_SYS(gettimeofday), SCMP_SYS(lseek),         SCMP_SYS(lstat),
    SCMP_SYS(madvise),         SCMP_SYS(mremap),       SCMP_SYS(munmap),        SCMP_SYS(nanosleep),
    SCMP_SYS(newfstatat),      SCMP_SYS(pause),        SCMP_SYS(poll),          SCMP_SYS(ppoll),
    SCMP_SYS(pread64),         SCMP_SYS(preadv),       SCMP_SYS(read),          SCMP_SYS(readlink),
    SCMP_SYS(readlinkat),      SCMP_SYS(readv),        SCMP_SYS(rseq),          SCMP_SYS(rt_sigaction),
    SCMP_SYS(rt_sigprocmask),  SCMP_SYS(rt_sigreturn), SCMP_SYS(sched_yield),   SCMP_SYS(sched_getaffinity),
    SCMP_SYS(set_robust_list), SCMP_SYS(sigaltstack),  SCMP_SYS(stat),          SCMP_SYS(statx),
    SCMP_SYS(sysinfo),         SCMP_SYS(time),         SCMP_SYS(uname)};

void set_limit(__rlimit_resource resource, std::uint64_t most) {
  rlimit limit{};
  getrlimit(resource, &limit);
  limit.rlim_max = std::min<rlim_t>(limit.rlim_max, most);
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_cur, limit.rlim_max);
  setrlimit(resource, &limit);
}

void set_limits(const SandboxLimits& limits) {
  set_limit(RLIMIT_AS, address_space_in_use() + limits.memory_bytes);
  set_limit(RLIMIT_CPU, static_cast<std::uint64_t>(limits.cpu_seconds));
  set_limit(RLIMIT_NOFILE, kOpenFiles);
  set_limit(RLIMIT_FSIZE, 0);
  set_limit(RLIMIT_CORE, 0);
}

using Filter = std::unique_ptr<void, decltype(&seccomp_release)>;

int allow(const Filter& filter, int call) {
  return seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 0);
}

/// Calls that are allowed with some arguments only.
int allow_in_part(const Filter& filter) {
  constexpr scmp_datum_t kWriting = O_ACCMODE | O_CREAT | O_TRUNC | O_APPEND;
  constexpr scmp_datum_t kExecutable = 4;  // PROT_EXEC
  scmp_filter_ctx f = filter.get();
  int error = 0;
  const auto add = [&](int call, const scmp_arg_cmp& condition) {
    error |= seccomp_rule_add(f, SCMP_ACT_ALLOW, call, 1, condition);
  };
  add(SCMP_SYS(open), SCMP_A1(SCMP_CMP_MASKED_EQ, kWriting, O_RDONLY));
  add(SCMP_SYS(openat), SCMP_A2(SCMP_CMP_MASKED_EQ, kWriting, O_RDONLY));
  add(SCMP_SYS(mmap), SCMP_A2(SCMP_CMP_MASKED_EQ, kExecutable, 0));
  add(SCMP_SYS(mprotect), SCMP_A2(SCMP_CMP_MASKED_EQ, kExecutable, 0));
  for (const scmp_datum_t stream : {STDOUT_FILENO, STDERR_FILENO}) {
    add(SCMP_SYS(write), SCMP_A0(SCMP_CMP_EQ, stream));
    add(SCMP_SYS(writev), SCMP_A0(SCMP_CMP_EQ, stream));
  }
  for (const scmp_datum_t command : {F_GETFD, F_SETFD, F_GETFL}) {
    add(SCMP_SYS(fcntl), SCMP_A1(SCMP_CMP_EQ, command));
  }
  // OpenVDB starts threads. glibc falls back from clone3(), whose flags a filter cannot see.
  add(SCMP_SYS(clone), SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, CLONE_THREAD));
  error |= seccomp_rule_add(f, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
  add(SCMP_SYS(prlimit64), SCMP_A2(SCMP_CMP_EQ, 0));  // reads a limit
  // abort() and raise() signal this process.
  const auto self = static_cast<scmp_datum_t>(getpid());
  add(SCMP_SYS(tgkill), SCMP_A0(SCMP_CMP_EQ, self));
  add(SCMP_SYS(kill), SCMP_A0(SCMP_CMP_EQ, self));
#ifdef __SANITIZE_ADDRESS__  // the sanitizers write to a pipe to know whether memory can be read
  error |= allow(filter, SCMP_SYS(pipe2)) | allow(filter, SCMP_SYS(write));
#endif
  return error;
}

bool restrict_system_calls() {
  const Filter filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)), &seccomp_release);
  if (!filter) return false;
  // Older kernels otherwise switch off speculation, which slows the reader down.
  seccomp_attr_set(filter.get(), SCMP_FLTATR_CTL_SSB, 1);
  int error = allow_in_part(filter);
  for (const int call : kAllowed) error |= allow(filter, call);
  return error == 0 && seccomp_load(filter.get()) == 0;
}

}  // namespace

int close_files(int keep) {
  const int null_device = open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(null_device, stream);
  constexpr int kKept = STDERR_FILENO + 1;
  if (keep > kKept) dup2(keep, kKept);
  close_range(kKept + 1, ~0U, 0);
  return kKept;
}

bool enter_sandbox(const SandboxLimits& limits, int keep) {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);  // the program may block signals that are to end this process
  for (const int fatal : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGILL, SIGXCPU, SIGINT, SIGTERM, SIGHUP}) {
    std::signal(fatal, SIG_DFL);
  }
  close_files(keep);  // libraries print about damaged files
  set_limits(limits);
  return restrict_system_calls();
}

bool restricts_system_calls() {
  const pid_t child = fork();
  if (child == 0) _exit(restrict_system_calls() ? 0 : 1);
  int status = 1;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return child > 0 && status == 0;
}

}  // namespace reamsim
