// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/output_folder.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "sim/base/error.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

TEST(FolderLock, WaitsForTheNameOfAHolderThatHasNotWrittenItYet) {
  const TempDir dir;
  const std::string out = dir.path() + "/run";
  const int other = open((out + ".lock").c_str(), O_RDWR | O_CREAT, 0666);
  ASSERT_EQ(flock(other, LOCK_EX), 0);
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
    EXPECT_EQ(write(other, "reamsim process 7\n", 18), 18);
  });
  try {
    const FolderLock lock(out);
    ADD_FAILURE() << "expected an error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("is in use by reamsim process 7; "));
  }
  writer.join();
  close(other);
}

TEST(FolderLock, ReleasedEarlyItLeavesTheNextHolderAlone) {
  const TempDir dir;
  FolderLock first(dir.path() + "/run");
  first.release();
  const FolderLock second(dir.path() + "/run");
  first.release();
  EXPECT_THROW(FolderLock(dir.path() + "/run"), InputError);
}

}  // namespace
}  // namespace reamsim::test
