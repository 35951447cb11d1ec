// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <thread>

#include "sim/isolation/read_in_child.h"

namespace reamsim::test {
namespace {

/// What `attempt` returns and the error number that it leaves, in a child that reads a file.
struct Attempt {
  long returned = 0;
  int error = 0;
};

template <auto Call, class... Arguments>
Attempt in_sandbox(Arguments... arguments) {
  constexpr auto kAttempt = [](ResultWriter& out, const Arguments&... values) {
    errno = 0;
    out.put(static_cast<long>(Call(values...)));
    out.put(errno);
  };
  ResultReader result = read_in_child<kAttempt>({"file", "key"}, {}, arguments...);
  Attempt out;
  out.returned = result.take<long>();
  out.error = result.take<int>();
  return out;
}

template <auto Call, class... Arguments>
void expect_denied(const char* what, Arguments... arguments) {
  const Attempt attempt = in_sandbox<Call>(arguments...);
  EXPECT_EQ(attempt.returned, -1) << what;
  EXPECT_EQ(attempt.error, EPERM) << what;
}

class SystemCalls : public ::testing::Test {
 protected:
  void SetUp() override {
    prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, nullptr);  // fails: EFAULT, for there is no filter
    if (errno != EFAULT) GTEST_SKIP() << "no seccomp here";
  }
};

TEST_F(SystemCalls, WhatReadingDoesNotNeedIsDenied) {
  expect_denied<[] { return socket(AF_INET, SOCK_STREAM, 0); }>("network");
  expect_denied<[] { return socket(AF_UNIX, SOCK_STREAM, 0); }>("local sockets");
  expect_denied<[] { return syscall(SYS_fork); }>("a process");
  expect_denied<[] { return execl("/bin/true", "true", nullptr); }>("a program");
  expect_denied<[] { return ptrace(PTRACE_ATTACH, getppid(), nullptr, nullptr); }>("ptrace");
  expect_denied<[] { return kill(getppid(), SIGTERM); }>("a signal to the parent");
  expect_denied<[] { return unlink("/tmp/reamsim_no_such_file"); }>("deleting");
  expect_denied<[] { return rename("/tmp/reamsim_no_such_file", "/tmp/reamsim_nor_this"); }>("renaming");
  expect_denied<[] {
    void* memory = mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return memory == MAP_FAILED ? -1 : 0;
  }>("executable memory");
  expect_denied<[] {
    const rlimit more{RLIM_INFINITY, RLIM_INFINITY};
    return setrlimit(RLIMIT_AS, &more);
  }>("other limits");
}

TEST_F(SystemCalls, OpeningForWritingIsDenied) {
  for (const int flags : {O_WRONLY, O_RDWR, O_RDONLY | O_CREAT, O_RDONLY | O_TRUNC, O_WRONLY | O_APPEND}) {
    expect_denied<[](int flags_of_open) { return open("/dev/null", flags_of_open, 0600); }>("open", flags);
  }
}

TEST(Sandbox, ReadingWorks) {
  const Attempt attempt = in_sandbox<[] {
    std::ifstream file("/proc/self/status");
    return file.get() == EOF ? -1 : 0;
  }>();
  EXPECT_EQ(attempt.returned, 0);
}

TEST(Sandbox, ThreadsOfALibraryWork) {
  const Attempt attempt = in_sandbox<[] {
    int done = 0;
    std::thread([&done] { done = 5; }).join();
    return done;
  }>();
  EXPECT_EQ(attempt.returned, 5);
}

TEST(Sandbox, FilesOfTheParentAreClosed) {
  const int opened = fcntl(STDERR_FILENO, F_DUPFD, 20);
  ASSERT_GE(opened, 20);
  const Attempt attempt = in_sandbox<[](int file) { return lseek(file, 0, SEEK_SET); }>(opened);
  EXPECT_EQ(attempt.returned, -1);
  EXPECT_EQ(attempt.error, EBADF);
  close(opened);
}

TEST(Sandbox, FewFilesAreOpenAtATime) {
  const Attempt attempt = in_sandbox<[] {
    int opened = 0;
    for (int n = 0; n < 1000; ++n) opened += open("/dev/null", O_RDONLY) >= 0 ? 1 : 0;
    return opened;
  }>();
  EXPECT_GT(attempt.returned, 8);
  EXPECT_LT(attempt.returned, 64);
  EXPECT_EQ(attempt.error, EMFILE);
}

}  // namespace
}  // namespace reamsim::test
