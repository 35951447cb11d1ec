// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Two ranges write one variable: the thread sanitizer must say so, or it watches nothing.
#include <chrono>
#include <thread>

#include "sim/base/parallel.h"

int main() {
  int shared = 0;
  reamsim::parallel_items(64, [&shared](std::size_t) {
    ++shared;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));  // so that a second thread takes items too
  });
  return 0;
}
