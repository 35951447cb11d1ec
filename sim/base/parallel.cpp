// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#ifdef REAMSIM_THREAD_SANITIZER
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#endif

namespace reamsim {

#ifdef REAMSIM_THREAD_SANITIZER

namespace {

constexpr std::size_t kThreads = 4;

/// Keeps oneTBB, which is not instrumented, on one thread, whichever library uses it: the sanitizer would report its
/// synchronization as races.
const tbb::global_control no_threads_of_onetbb(tbb::global_control::max_allowed_parallelism, 1);

}  // namespace

void parallel_ranges(std::size_t count, std::size_t grain, const RangeBody& body) {
  const std::size_t ranges = std::max<std::size_t>(1, count / std::max<std::size_t>(1, grain));
  std::atomic<std::size_t> next = 0;
  std::mutex guard;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (std::size_t i; count > 0 && (i = next.fetch_add(1, std::memory_order_relaxed)) < ranges;) {
        body(count * i / ranges, count * (i + 1) / ranges);
      }
    } catch (...) {
      const std::scoped_lock lock(guard);
      failure = std::current_exception();
      next = ranges;
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (std::size_t i = 1; i < std::min(kThreads, ranges); ++i) helpers.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

#else

void parallel_ranges(std::size_t count, std::size_t grain, const RangeBody& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                    [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); });
}

#endif

}  // namespace reamsim
