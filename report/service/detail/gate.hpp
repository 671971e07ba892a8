#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>

namespace carillon::report::service {

/// Lets so many computations run at once, and so many more wait.
class Gate {
 public:
  Gate(std::size_t running, std::size_t waiting) : free_(running), seats_(waiting) {}

  /// A computation's place, for as long as it lives.
  class Pass {
   public:
    explicit Pass(Gate* gate) : gate_(gate) {}
    ~Pass() {
      if (gate_ != nullptr) gate_->leave();
    }
    Pass(const Pass&) = delete;
    Pass& operator=(const Pass&) = delete;
    /// Whether there is one: too many wait already.
    explicit operator bool() const { return gate_ != nullptr; }

   private:
    Gate* gate_;
  };

  /// Waits for a place, where there is a seat to wait in.
  Pass enter() {
    std::unique_lock lock(mutex_);
    if (free_ == 0) {
      if (seats_ == 0) return Pass(nullptr);
      --seats_;
      left_.wait(lock, [this] { return free_ > 0; });
      ++seats_;
    }
    --free_;
    return Pass(this);
  }

 private:
  void leave() {
    {
      const std::lock_guard lock(mutex_);
      ++free_;
    }
    left_.notify_one();
  }

  std::mutex mutex_;
  std::condition_variable left_;
  std::size_t free_, seats_;
};

}  // namespace carillon::report::service
