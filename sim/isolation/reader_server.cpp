// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/isolation/reader_server.h"

#include <sched.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <stdexcept>
#include <vector>

#include "sim/base/error.h"
#include "sim/isolation/child_result.h"
#include "sim/isolation/sandbox.h"

namespace reamsim {

namespace {

/// A message of a ChildStart, with room for the control message that carries one descriptor.
struct Message {
  explicit Message(ChildStart& start) : data{&start, sizeof start} {
    head.msg_iov = &data;
    head.msg_iovlen = 1;
    head.msg_control = control.data();
    head.msg_controllen = control.size();
  }
  Message(const Message&) = delete;
  Message& operator=(const Message&) = delete;
  ~Message() = default;

  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  iovec data;
  msghdr head{};
};

/// Sends plain bytes and a descriptor. Returns whether it succeeded.
bool send_with_descriptor(int socket, const ChildStart& start, int descriptor) {
  ChildStart copy = start;
  Message message(copy);
  cmsghdr* head = CMSG_FIRSTHDR(&message.head);
  head->cmsg_level = SOL_SOCKET;
  head->cmsg_type = SCM_RIGHTS;
  head->cmsg_len = CMSG_LEN(sizeof descriptor);
  std::memcpy(CMSG_DATA(head), &descriptor, sizeof descriptor);
  ssize_t sent = 0;
  while ((sent = sendmsg(socket, &message.head, MSG_NOSIGNAL)) < 0 && errno == EINTR) {
  }
  return sent == static_cast<ssize_t>(sizeof start);
}

/// Receives what send_with_descriptor() sent. Returns the descriptor; −1 when the other side has ended.
int receive_with_descriptor(int socket, ChildStart& start) {
  Message message(start);
  ssize_t received = 0;
  while ((received = recvmsg(socket, &message.head, MSG_CMSG_CLOEXEC)) < 0 && errno == EINTR) {
  }
  const cmsghdr* head = CMSG_FIRSTHDR(&message.head);
  if (received != static_cast<ssize_t>(sizeof start) || head == nullptr) return -1;
  int descriptor = -1;
  std::memcpy(&descriptor, CMSG_DATA(head), sizeof descriptor);
  return descriptor;
}

/// Returns how it ended. What a failed attempt wrote is replaced by the error.
ChildOutcome write_result(ChildFunction function, ResultReader& arguments, ResultWriter& out) {
  try {
    function(arguments, out);
    return ChildOutcome::done;
  } catch (const InputError& error) {
    out.clear();
    put_mistakes(out, error);
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

[[noreturn]] void work_and_exit(const ChildStart& start, int alive) {
  live_as_long_as_program();
  try {
    SharedMemory memory(start.memory);
    enter_sandbox({start.memory_bytes, start.cpu_seconds}, alive);
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
  for (int alive; (alive = receive_with_descriptor(socket, start)) >= 0;) {
    const pid_t child = fork_sibling();
    if (child == 0) {
      close(socket);
      work_and_exit(start, alive);
    }
    const pid_t answer = child < 0 ? -errno : child;
    close(alive);
    if (send(socket, &answer, sizeof answer, MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof answer)) break;
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
  while (waitpid(process, nullptr, 0) < 0 && errno == EINTR) {
  }
}

pid_t start_child(const ChildStart& start, int alive) {
  const std::lock_guard lock(server_mutex);
  require_server();
  pid_t child = -EPIPE;  // the server has ended
  const bool sent = send_with_descriptor(server, start, alive);
  while (sent && recv(server, &child, sizeof child, 0) < 0 && errno == EINTR) {
  }
  if (child > 0) return child;
  errno = -child;
  fail_to_start();
}

}  // namespace reamsim
