#pragma once

#include <atomic>
#include <memory>
#include <utility>

namespace carillon::synth::live {

/// Elements that any threads send and one takes, without a lock and without memory of its own: they
/// are linked by their member `next`. Taking is one exchange and a walk; it never waits for a
/// sender.
template <class Element>
class Mailbox {
 public:
  Mailbox() = default;
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;
  ~Mailbox() {
    take_all([](std::unique_ptr<Element>) {});
  }

  void send(std::unique_ptr<Element> element) {
    Element* sent = element.release();
    sent->next = newest_.load(std::memory_order_relaxed);
    // A new element that has come meanwhile is the next one.
    while (!newest_.compare_exchange_weak(sent->next, sent, std::memory_order_release,
                                          std::memory_order_relaxed)) {
    }
  }

  /// Hands over what has been sent so far, in the order of sending.
  template <class Take>
  void take_all(Take&& take) {
    Element* newest = newest_.exchange(nullptr, std::memory_order_acquire);
    Element* oldest = nullptr;
    while (newest != nullptr) {
      Element* before = std::exchange(newest->next, oldest);
      oldest = std::exchange(newest, before);
    }
    while (oldest != nullptr) {
      Element* next = std::exchange(oldest->next, nullptr);
      take(std::unique_ptr<Element>(oldest));
      oldest = next;
    }
  }

 private:
  static_assert(std::atomic<Element*>::is_always_lock_free);
  std::atomic<Element*> newest_ = nullptr;
};

}  // namespace carillon::synth::live
