#include "render/pictures/photo_queue.h"

#include <utility>

namespace reamsim {
namespace {

std::size_t bytes_of(const Photo& photo) {
  return photo.image.pixels.size() * sizeof(photo.image.pixels[0]);
}

}  // namespace

bool PhotoQueue::push(Photo photo) {
  const std::size_t size = bytes_of(photo);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return closed_ || photos_.empty() || bytes_ + size <= most_bytes_; });
  if (closed_) return false;
  bytes_ += size;
  photos_.push_back(std::move(photo));
  changed_.notify_all();
  return true;
}

void PhotoQueue::end(std::exception_ptr why) {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  why_ = std::move(why);
  changed_.notify_all();
}

std::optional<Photo> PhotoQueue::pop() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return ended_ || !photos_.empty(); });
  if (photos_.empty()) {
    if (why_) std::rethrow_exception(why_);
    return std::nullopt;
  }
  Photo out = std::move(photos_.front());
  photos_.pop_front();
  bytes_ -= bytes_of(out);
  changed_.notify_all();
  return out;
}

void PhotoQueue::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

}  // namespace reamsim
