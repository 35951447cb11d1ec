// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/isolation/read_in_child.h"

#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <stdexcept>

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

void set_limits(const ChildStart& start) {
  set_limit(RLIMIT_AS, address_space_in_use() + start.memory_bytes);
  set_limit(RLIMIT_CPU, static_cast<std::uint64_t>(start.cpu_seconds));
  set_limit(RLIMIT_NOFILE, kOpenFiles);
  set_limit(RLIMIT_FSIZE, 0);
  set_limit(RLIMIT_CORE, 0);
}

using Filter = std::unique_ptr<void, decltype(&seccomp_release)>;

/// Calls that are allowed with some arguments only.
int allow_in_part(const Filter& filter) {
  constexpr scmp_datum_t kWriting = O_ACCMODE | O_CREAT | O_TRUNC | O_APPEND;
  constexpr scmp_datum_t kExecutable = 4;  // PROT_EXEC
  scmp_filter_ctx f = filter.get();
  int error = 0;
  const auto add = [&](int call, const scmp_arg_cmp& condition) {
    error |= seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 1, condition);
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
  for (const int call : {SCMP_SYS(pipe2), SCMP_SYS(write)})
    error |= seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 0);
#endif
  return error;
}

/// Does nothing where the kernel has no seccomp.
void restrict_system_calls() {
  const Filter filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)), &seccomp_release);
  if (!filter) return;
  // Older kernels otherwise switch off speculation, which slows the reader down.
  seccomp_attr_set(filter.get(), SCMP_FLTATR_CTL_SSB, 1);
  int error = allow_in_part(filter);
  for (const int call : kAllowed) error |= seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 0);
  if (error == 0) seccomp_load(filter.get());
}

/// Connects the standard streams to /dev/null and closes every other file but `keep` (−1: none). Returns the new number
/// of that one.
int close_files(int keep) {
  const int null_device = open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(null_device, stream);
  constexpr int kKept = STDERR_FILENO + 1;
  if (keep > kKept) dup2(keep, kKept);
  close_range(keep < 0 ? kKept : kKept + 1, ~0U, 0);
  return kKept;
}

void enter_sandbox(const ChildStart& start) {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);  // the program may block signals that are to end this process
  for (const int fatal : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGILL, SIGXCPU, SIGINT, SIGTERM, SIGHUP}) {
    std::signal(fatal, SIG_DFL);
  }
  close_files(-1);  // libraries print about damaged files
  set_limits(start);
  restrict_system_calls();
}

/// Sends a value to the other side. Returns false when that has ended.
template <PlainValue T>
bool send_value(int socket, const T& value) {
  return TEMP_FAILURE_RETRY(send(socket, &value, sizeof value, MSG_NOSIGNAL)) == ssize_t{sizeof value};
}

/// Receives what send_value() sent.
template <PlainValue T>
bool receive_value(int socket, T& value) {
  return TEMP_FAILURE_RETRY(recv(socket, &value, sizeof value, 0)) == ssize_t{sizeof value};
}

ChildOutcome write_result(ChildFunction function, ResultReader& arguments, ResultWriter& out) {
  try {
    function(arguments, out);
    return ChildOutcome::done;
  } catch (const InputError& error) {
    out.clear();
    out.put(error.mistakes());
    return ChildOutcome::wrong_input;
  } catch (const ResultTooLarge&) {
    return ChildOutcome::result_too_large;
  } catch (const std::bad_alloc&) {
    return ChildOutcome::out_of_memory;
  } catch (const std::length_error&) {
    return ChildOutcome::out_of_memory;
  } catch (const RunError& error) {
    out.clear();
    out.put(std::string(error.what()));
    return ChildOutcome::failed;
  }
}

// Global, because a signal handler reads it.
pid_t program = 0;  // the process that the server and the children belong to

void exit_without_program(int = 0) {
  if (getppid() != program) _exit(1);
}

/// Ends this process when the program does. The system signals the end of the thread that started the server, too, so
/// that the signal alone must end nothing.
void live_as_long_as_program() {
  std::signal(SIGUSR1, exit_without_program);
  prctl(PR_SET_PDEATHSIG, SIGUSR1);
  exit_without_program();
}

[[noreturn]] void work_and_exit(const ChildStart& start) {
  live_as_long_as_program();
  try {
    SharedMemory memory(start.memory);
    enter_sandbox(start);
    // A copy, because the result takes their place.
    const std::vector<std::byte> bytes(memory.result(), memory.result() + memory.head().bytes);
    ResultReader arguments(bytes);
    ResultWriter out(memory);
    out.clear();
    memory.head().outcome = write_result(start.function, arguments, out);
  } catch (...) {  // of a library, or no room for the error
    _exit(1);
  }
  _exit(0);
}

/// A fork whose parent is the parent of this process, so that it can wait for it.
pid_t fork_sibling() {
  return static_cast<pid_t>(syscall(SYS_clone, CLONE_PARENT | SIGCHLD, nullptr, nullptr, nullptr, nullptr));
}

[[noreturn]] void serve(int socket, pid_t parent) {
  program = parent;
  // The program decides when to end; Ctrl-C in a terminal reaches this process too.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGQUIT, SIGPIPE, SIGXFSZ}) {
    std::signal(signal, SIG_IGN);
  }
  socket = close_files(socket);
  ChildStart start;
  while (receive_value(socket, start)) {
    const pid_t child = fork_sibling();
    if (child == 0) work_and_exit(start);
    const pid_t answer = child < 0 ? -errno : child;
    if (!send_value(socket, answer)) break;
  }
  _exit(0);
}

// Global: there is one server for a process.
std::mutex server_mutex;
int server = -1;                         // this process's end of the socket; −1 = not started
pid_t owner = 0;                         // the process that started the server; its forks have none
std::atomic<pid_t> server_process = -1;  // −1 = none, or ended

[[noreturn]] void fail_to_start() {
  throw RunError(std::string("no child process to read files: ") + std::strerror(errno));
}

void start_server() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) fail_to_start();
  const pid_t parent = getpid();
  const pid_t process = fork();
  if (process == 0) {
    close(ends[0]);
    serve(ends[1], parent);
  }
  const int error = errno;
  close(ends[1]);
  if (process < 0) {
    close(ends[0]);
    errno = error;
    fail_to_start();
  }
  server = ends[0];
  owner = parent;
  if (server_process.exchange(process) < 0) std::atexit(stop_reader_server);
}

void require_server() {
  if (server >= 0 && owner == getpid()) return;
  if (server >= 0) close(server);
  start_server();
}

}  // namespace

void start_reader_server() {
  const std::lock_guard lock(server_mutex);
  require_server();
}

void stop_reader_server() {
  const pid_t process = owner == getpid() ? server_process.exchange(-1) : -1;
  if (process < 0) return;
  kill(process, SIGKILL);
  wait_for(process);
}

pid_t start_child(const ChildStart& start) {
  const std::lock_guard lock(server_mutex);
  require_server();
  pid_t child = -EPIPE;  // the server has ended
  if (send_value(server, start)) receive_value(server, child);
  if (child > 0) return child;
  errno = -child;
  fail_to_start();
}

}  // namespace reamsim
