#include "render/frame_queue.h"

#include <utility>

namespace reamsim {
namespace {

std::size_t bytes_of(const RenderedFrame& frame) {
  return frame.image.pixels.size() * sizeof(frame.image.pixels[0]);
}

}  // namespace

bool FrameQueue::push(RenderedFrame frame) {
  const std::size_t size = bytes_of(frame);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return closed_ || frames_.empty() || bytes_ + size <= most_bytes_; });
  if (closed_) return false;
  bytes_ += size;
  frames_.push_back(std::move(frame));
  changed_.notify_all();
  return true;
}

void FrameQueue::end(std::exception_ptr why) {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  why_ = std::move(why);
  changed_.notify_all();
}

std::optional<RenderedFrame> FrameQueue::pop() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return ended_ || !frames_.empty(); });
  if (frames_.empty()) {
    if (why_) std::rethrow_exception(why_);
    return std::nullopt;
  }
  RenderedFrame out = std::move(frames_.front());
  frames_.pop_front();
  bytes_ -= bytes_of(out);
  changed_.notify_all();
  return out;
}

void FrameQueue::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

}  // namespace reamsim
