#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace reamsim {

/// Tells a thread that draws which snapshots a simulation has written already. All members may be called by any thread.
class SnapshotFeed {
 public:
  /// All snapshots up to and including this frame's are on disk.
  void reached(std::int64_t frame);
  /// Nobody waits any more.
  void abandon();
  /// Returns when the frame is reached; false where the feed is abandoned.
  bool wait_for(std::int64_t frame);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::int64_t reached_ = -1;
  bool abandoned_ = false;
};

}  // namespace reamsim
