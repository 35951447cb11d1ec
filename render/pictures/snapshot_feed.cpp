#include "render/pictures/snapshot_feed.h"

#include <algorithm>

namespace reamsim {

void SnapshotFeed::reached(std::int64_t frame) {
  {
    const std::lock_guard lock(mutex_);
    reached_ = std::max(reached_, frame);
  }
  changed_.notify_all();
}

void SnapshotFeed::abandon() {
  {
    const std::lock_guard lock(mutex_);
    abandoned_ = true;
  }
  changed_.notify_all();
}

bool SnapshotFeed::wait_for(std::int64_t frame) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return abandoned_ || reached_ >= frame; });
  return !abandoned_;
}

}  // namespace reamsim
