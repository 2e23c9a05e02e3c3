#include "bench/live/mailbox.h"

namespace ertbench {

bool Mailbox::put(ArrivedFrame frame) {
  {
    std::unique_lock lock(mutex_);
    if (lossless_) changed_.wait(lock, [&] { return closed_ || frames_.size() < places_; });
    if (closed_) return false;
    if (frames_.size() == places_) {
      frames_.pop_front();
      ++dropped_;
    }
    frames_.push_back(std::move(frame));
  }
  changed_.notify_all();
  return true;
}

Mailbox::Taken Mailbox::take(ArrivedFrame& frame, std::chrono::milliseconds patience) {
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [&] { return closed_ || !frames_.empty(); });
    if (frames_.empty()) return closed_ ? Taken::closed : Taken::nothing;
    frame = std::move(frames_.front());
    frames_.pop_front();
  }
  changed_.notify_all();
  return Taken::frame;
}

void Mailbox::close(bool now) {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    if (now) {
      dropped_ += frames_.size();
      frames_.clear();
    }
  }
  changed_.notify_all();
}

std::uint64_t Mailbox::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace ertbench
