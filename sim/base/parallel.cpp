#include "sim/base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#ifdef REAMSIM_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace reamsim {

namespace {

/// Tells the thread sanitizer in which order oneTBB lets things happen; does nothing in other builds. Only what oneTBB
/// promises is told: the caller comes before every range, and every range before the caller goes on. Ranges are not
/// ordered among each other, so races between them are still found.
class HandOver {
 public:
#ifdef REAMSIM_THREAD_SANITIZER
  void give() {
    __tsan_release(this);
  }
  void take() {
    __tsan_acquire(this);
  }
#else
  void give() {}
  void take() {}
#endif
};

/// Gives when it goes out of scope, also by an exception.
class GiveAtEnd {
 public:
  explicit GiveAtEnd(HandOver& hand_over) : hand_over_(hand_over) {}
  GiveAtEnd(const GiveAtEnd&) = delete;
  GiveAtEnd& operator=(const GiveAtEnd&) = delete;
  ~GiveAtEnd() { hand_over_.give(); }

 private:
  HandOver& hand_over_;
};

}  // namespace

void parallel_ranges(std::size_t count, std::size_t grain, const RangeBody& body) {
  HandOver to_ranges, to_caller;
  to_ranges.give();
  const auto run = [&](const tbb::blocked_range<std::size_t>& range) {
    to_ranges.take();
    const GiveAtEnd end(to_caller);
    body(range.begin(), range.end());
  };
  try {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), run);
  } catch (...) {
    to_caller.take();
    throw;
  }
  to_caller.take();
}

}  // namespace reamsim
