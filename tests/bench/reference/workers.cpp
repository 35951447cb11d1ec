// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/bench/reference/workers.h"

#include <algorithm>
#include <chrono>

namespace reamsim::reference {

namespace {

constexpr std::chrono::microseconds kOpenEyes{100};

/// Returns when `value` is no longer `old`.
void wait_for_change(const std::atomic<unsigned>& value, unsigned old) {
  const auto end = std::chrono::steady_clock::now() + kOpenEyes;
  while (value.load(std::memory_order_acquire) == old) {
    if (std::chrono::steady_clock::now() > end) value.wait(old, std::memory_order_acquire);
  }
}

}  // namespace

Workers::Workers(unsigned count) {
  for (unsigned i = 1; i < std::max(1U, count); ++i) threads_.emplace_back([this] { serve(); });
}

Workers::~Workers() {
  work_ = nullptr;
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Workers::run(const std::function<void()>& work) {
  work_ = &work;
  busy_.store(static_cast<unsigned>(threads_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  work();
  for (unsigned busy = busy_.load(std::memory_order_acquire); busy != 0; busy = busy_.load(std::memory_order_acquire)) {
    wait_for_change(busy_, busy);
  }
}

void Workers::serve() {
  for (unsigned round = 0;; ++round) {
    wait_for_change(round_, round);
    if (work_ == nullptr) return;
    (*work_)();
    busy_.fetch_sub(1, std::memory_order_release);
    busy_.notify_one();
  }
}

}  // namespace reamsim::reference
