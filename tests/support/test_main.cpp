// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The main function of every GoogleTest program. As that of reamsim, it starts the server of readers before there are
// threads: a fork of a process with threads may inherit a lock that nobody releases, and a reader would wait forever.
// Ends with 77, for CTest's SKIP_RETURN_CODE, where tests were skipped and none failed.
#include <gtest/gtest.h>

#include "sim/isolation/read_in_child.h"

int main(int argc, char** argv) {
  reamsim::start_reader_server();
  testing::InitGoogleTest(&argc, argv);
  const int status = RUN_ALL_TESTS();
  return status == 0 && testing::UnitTest::GetInstance()->skipped_test_count() > 0 ? 77 : status;
}
