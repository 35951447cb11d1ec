// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/isolation/read_in_child.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <numeric>
#include <thread>
#include <vector>

#include "sim/base/error.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

const ForeignFile kFile{"scan.nrrd", "bone.ct.path"};

template <auto Read, class... Arguments>
std::string input_error(const ReadLimits& limits = {}, const Arguments&... arguments) {
  try {
    read_in_child<Read>(kFile, limits, arguments...);
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no InputError";
  return "";
}

/// Keeps the processor busy for ever.
void loop() {
  for (volatile unsigned n = 0;;) n = n + 1;
}

/// Child processes that a process has.
std::vector<pid_t> children(pid_t process) {
  std::vector<pid_t> out;
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
    std::ifstream list(task.path() / "children");
    for (pid_t child = 0; list >> child;) out.push_back(child);
  }
  return out;
}

TEST(ReadInChild, HandsBackNumbersTextsAndArrays) {
  constexpr std::size_t kMany = 5'000'000;  // several blocks
  ReadLimits limits;
  limits.result_bytes = kMany * sizeof(float) + 4096;
  ResultReader in = read_in_child<[](ResultWriter& out) {
    out.put(7);
    out.put(std::string("text\0 with zero", 15));
    out.put(2.5);
    float* values = out.array<float>(kMany);
    std::iota(values, values + kMany, 0.0F);
    out.put(std::vector<std::int16_t>{});
    out.put(std::string());
  }>(kFile, limits);
  EXPECT_EQ(in.take<int>(), 7);
  EXPECT_EQ(in.text(), std::string("text\0 with zero", 15));
  EXPECT_EQ(in.take<double>(), 2.5);
  const std::vector<float> values = in.take<std::vector<float>>();
  ASSERT_EQ(values.size(), kMany);
  for (std::size_t i = 0; i < kMany; i += 999) ASSERT_EQ(values[i], static_cast<float>(i));
  EXPECT_TRUE(in.take<std::vector<std::int16_t>>().empty());
  EXPECT_EQ(in.text(), "");
  EXPECT_THROW(in.take<char>(), InputError) << "behind the end";
}

TEST(ReadInChild, TakesItsArgumentsByTheirTypes) {
  constexpr auto kRead = [](ResultWriter& out, int number, const std::string& text, const std::vector<double>& values,
                            const std::vector<std::string>& texts) {
    out.put(text + std::to_string(number) + texts.back());
    out.put(values);
  };
  const std::vector<double> values{1.5, -2};
  const std::vector<std::string> texts{"", "end"};
  ResultReader result = read_in_child<kRead>(kFile, {}, 7, std::string("text"), values, texts);
  EXPECT_EQ(result.text(), "text7end");
  EXPECT_EQ(result.take<std::vector<double>>(), values);
}

TEST(ReadInChild, SeveralThreadsReadAtATime) {
  std::vector<std::thread> threads;
  std::atomic<int> sum = 0;
  for (int thread = 0; thread < 8; ++thread) {
    threads.emplace_back([&sum, thread] {
      for (int n = 0; n < 20; ++n) {
        constexpr auto kRead = [](ResultWriter& out, int number) { out.put(number); };
        sum += read_in_child<kRead>(kFile, {}, thread).take<int>();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(sum, 20 * 28);
}

/// Takes some milliseconds.
constexpr auto kReadSlowly = [](ResultWriter& out, int milliseconds) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
  out.put(milliseconds);
};

TEST(ReadInChild, TheThreadThatStartedTheServerMayEnd) {
  std::atomic<bool> started = false;
  std::thread first([&] {
    read_in_child<kReadSlowly>(kFile, {}, 1);
    started = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  });
  while (!started) std::this_thread::yield();
  EXPECT_EQ(read_in_child<kReadSlowly>(kFile, {}, 400).take<int>(), 400);
  first.join();
}

TEST(ReadInChild, ServerAndChildEndWithTheProgram) {
  prctl(PR_SET_CHILD_SUBREAPER, 1);  // the processes of a program that has ended become children of this one
  const pid_t program = fork();
  if (program == 0) {
    std::thread([] { read_in_child<[](ResultWriter&) { pause(); }>(kFile, {}); }).join();
    _exit(0);
  }
  while (children(program).size() < 2) std::this_thread::yield();
  const std::vector<pid_t> processes = children(program);
  kill(program, SIGKILL);
  EXPECT_EQ(waitpid(program, nullptr, 0), program);
  for (const pid_t process : processes) EXPECT_EQ(waitpid(process, nullptr, 0), process);
  prctl(PR_SET_CHILD_SUBREAPER, 0);
}

TEST(ReadInChild, ChangesNothingInTheParent) {
  static int number = 1;
  read_in_child<[](ResultWriter&) { number = 2; }>(kFile, {});
  EXPECT_EQ(number, 1);
}

TEST(ReadInChild, ThrowsTheErrorsOfTheReader) {
  try {
    read_in_child<[](ResultWriter& out) {
      out.put(1);
      throw InputError({{{"a.yaml", 3, 4}, "key", "found", "expected"}, {{"b.yaml", 0, 0}, "", "only found", ""}});
    }>(kFile, {});
    FAIL() << "no InputError";
  } catch (const InputError& error) {
    ASSERT_EQ(error.mistakes().size(), 2U);
    EXPECT_EQ(error.mistakes()[0].line(), "a.yaml:3:4: key: found; expected");
    EXPECT_EQ(error.mistakes()[1].line(), "b.yaml: only found");
  }
  try {
    read_in_child<[](ResultWriter&) { throw RunError("no device"); }>(kFile, {});
    FAIL() << "no RunError";
  } catch (const RunError& error) {
    EXPECT_STREQ(error.what(), "no device");
  }
}

TEST(ReadInChild, ACrashNamesTheFile) {
  EXPECT_THAT(input_error<[](ResultWriter&) { std::raise(SIGSEGV); }>(),
              HasSubstr("scan.nrrd: bone.ct.path: the library that reads it crashed (signal 11); the file is damaged"));
  EXPECT_THAT(input_error<[](ResultWriter&) { std::abort(); }>(), HasSubstr("crashed (signal 6)"));
  EXPECT_THAT(input_error<[](ResultWriter&) { throw 1; }>(), HasSubstr("the library that reads it failed"));
  EXPECT_THAT(input_error<[](ResultWriter&) { _Exit(0); }>(), HasSubstr("the library that reads it failed"));
}

TEST(ReadInChild, ACrashNamesTheFileThatWasBeingRead) {
  EXPECT_THAT(input_error<[](ResultWriter& out) {
                out.begin_file("slice1.dcm");
                out.begin_file("slice2.dcm");
                std::abort();
              }>(),
              HasSubstr("slice2.dcm: bone.ct.path"));
}

TEST(ReadInChild, AnEndlessLoopEndsAtTheLimitOfTime) {
  ReadLimits limits;
  limits.seconds = 1;
  EXPECT_THAT(input_error<[](ResultWriter&) { loop(); }>(limits),
              HasSubstr("scan.nrrd: bone.ct.path: reading it took more than 1 s"));
  EXPECT_THAT(input_error<[](ResultWriter&) { pause(); }>(limits), HasSubstr("waited for more than 10 s"));
}

TEST(ReadInChild, TheLimitOfTimeCountsForEachFile) {
  ReadLimits limits;
  limits.seconds = 1;
  limits.files = 3;
  constexpr auto kRead = [](ResultWriter& out) {
    for (int file = 0; file < 3; ++file) {
      out.begin_file("slice");
      const std::clock_t begun = std::clock();
      while (std::clock() - begun < CLOCKS_PER_SEC * 6 / 10) {
      }
    }
    out.put(3);
  };
  EXPECT_EQ(read_in_child<kRead>(kFile, limits).take<int>(), 3);
}

TEST(ReadInChild, MemoryAndResultHaveLimits) {
  ReadLimits limits;
  limits.memory_bytes = 100'000'000;
  limits.result_bytes = 2'000'000;
  constexpr auto kTake = [](ResultWriter& out, std::size_t bytes) { out.put(std::vector<char>(bytes, 'x').back()); };
  EXPECT_NO_THROW(read_in_child<kTake>(kFile, limits, std::size_t{50'000'000}));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they end the process
  EXPECT_THAT(input_error<kTake>(limits, std::size_t{150'000'000}), HasSubstr("reading it needs more than 100 MB"));
#endif
  EXPECT_THAT(input_error<[](ResultWriter& out) { out.array<char>(3'000'000); }>(limits),
              HasSubstr("reading it needs more than 2 MB"));
}

TEST(ReadInChild, AStopRequestEndsTheChildSoon) {
  static std::chrono::steady_clock::time_point begun;
  begun = std::chrono::steady_clock::now();
  static constexpr auto kUntilStop = std::chrono::milliseconds(100);
  interrupt_reading_when([] { return std::chrono::steady_clock::now() - begun > kUntilStop; });
  EXPECT_THROW(read_in_child<[](ResultWriter&) { loop(); }>(kFile, {}), Interrupted);
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(1));
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), 0) << "no child has ended without being waited for";
  EXPECT_EQ(children(getpid()).size(), 1U) << "the server";
}

TEST(ReadInChild, CtrlCInATerminalReachesTheChildFirst) {
  EXPECT_THROW(read_in_child<[](ResultWriter&) { std::raise(SIGINT); }>(kFile, {}), Interrupted);
}

}  // namespace
}  // namespace reamsim::test
