// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

namespace reamsim {

/// Work on the items `begin`…`end` − 1.
using RangeBody = std::function<void(std::size_t begin, std::size_t end)>;

/// Splits the items 0…count − 1 into ranges of at least grain/2 items, calls `body` for each from the host's threads at
/// once and in no order, and returns when all are done. Throws one of the exceptions of `body`. All parallel work of
/// the project goes through it: the thread sanitizer needs plain threads, because Debian's oneTBB is not instrumented.
void parallel_ranges(std::size_t count, std::size_t grain, const RangeBody& body);

/// Calls body(i) for every item 0…count − 1, as parallel_ranges() does.
template <typename ItemBody>
void parallel_items(std::size_t count, std::size_t grain, const ItemBody& body) {
  parallel_ranges(count, grain, [&body](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}
template <typename ItemBody>
void parallel_items(std::size_t count, const ItemBody& body) {
  parallel_items(count, 1, body);
}

/// Calls compute(i, result) for every item as parallel_items() does, `at_once` items at a time in bounded memory, and
/// take(i, result) in order by one thread. A result holds what an earlier item left in it.
template <class Result, class Compute, class Take>
void parallel_in_order(std::size_t count, std::size_t at_once, const Compute& compute, const Take& take) {
  std::vector<Result> results(std::min(at_once, count));
  for (std::size_t first = 0; first < count; first += at_once) {
    const std::size_t part = std::min(at_once, count - first);
    parallel_items(part, [&](std::size_t i) { compute(first + i, results[i]); });
    for (std::size_t i = 0; i < part; ++i) take(first + i, results[i]);
  }
}

}  // namespace reamsim
