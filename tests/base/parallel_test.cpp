// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <vector>

namespace reamsim {
namespace {

TEST(Parallel, VisitsEveryItemOnce) {
  for (const std::size_t count : {0, 1, 7, 4096, 100003}) {
    std::vector<int> visits(count, 0);
    parallel_items(count, [&](std::size_t i) { ++visits[i]; });
    EXPECT_EQ(std::count(visits.begin(), visits.end(), 1), static_cast<std::ptrdiff_t>(count));
  }
}

TEST(Parallel, KeepsRangesAboveHalfTheGrain) {
  constexpr std::size_t kCount = 100003, kGrain = 1000;
  std::atomic<std::size_t> smallest = kCount;
  std::atomic<std::size_t> items = 0;
  parallel_ranges(kCount, kGrain, [&](std::size_t begin, std::size_t end) {
    std::size_t seen = smallest;
    while (end - begin < seen && !smallest.compare_exchange_weak(seen, end - begin)) continue;
    items += end - begin;
  });
  EXPECT_GE(smallest, kGrain / 2);
  EXPECT_EQ(items, kCount);
}

TEST(Parallel, HandsWhatABodyThrowsToTheCaller) {
  const auto fail = [](std::size_t i) {
    if (i == 777) throw std::runtime_error("item 777");
  };
  EXPECT_THROW(parallel_items(1000, fail), std::runtime_error);
}

/// The thread sanitizer reports this one unless it sees that the caller's writes come before every range, and the
/// ranges' writes before the caller goes on.
TEST(Parallel, OrdersTheCallerBeforeTheRangesAndAfterThem) {
  std::vector<std::size_t> value(10000, 0);
  for (std::size_t round = 1; round <= 20; ++round) {
    for (std::size_t& v : value) ++v;
    parallel_items(value.size(), [&](std::size_t i) { value[i] += value[i]; });
    EXPECT_EQ(value.back(), (std::size_t{2} << round) - 2);
  }
}

}  // namespace
}  // namespace reamsim
