#pragma once

#include <memory>
#include <utility>

namespace carillon::synth::modal {

/// Owns elements that are linked by their own member `next`, in their order: adding and taking
/// allocate nothing.
template <class Element>
class OwnedList {
 public:
  OwnedList() = default;
  OwnedList(const OwnedList&) = delete;
  OwnedList& operator=(const OwnedList&) = delete;
  OwnedList(OwnedList&& other) noexcept
      : first_(std::exchange(other.first_, nullptr)), last_(std::exchange(other.last_, nullptr)) {}
  OwnedList& operator=(OwnedList&& other) noexcept {
    std::swap(first_, other.first_);
    std::swap(last_, other.last_);
    return *this;
  }
  ~OwnedList() {
    while (pop_front()) continue;
  }

  Element* first() const { return first_; }

  void push_back(std::unique_ptr<Element> element) { insert_after(last_, std::move(element)); }

  /// @param place  an element of the list; null: the new one becomes the first
  void insert_after(Element* place, std::unique_ptr<Element> element) {
    Element*& link = place == nullptr ? first_ : place->next;
    element->next = link;
    if (place == last_) last_ = element.get();
    link = element.release();
  }

  /// @return the first element, which the list forgets; null where there is none
  std::unique_ptr<Element> pop_front() { return first_ == nullptr ? nullptr : take_after(nullptr); }

  /// Takes out the element behind another one, of which there must be one.
  /// @param place  null: the first
  std::unique_ptr<Element> take_after(Element* place) {
    Element*& link = place == nullptr ? first_ : place->next;
    std::unique_ptr<Element> taken(link);
    link = taken->next;
    if (taken.get() == last_) last_ = place;
    taken->next = nullptr;
    return taken;
  }

 private:
  Element* first_ = nullptr;
  Element* last_ = nullptr;
};

}  // namespace carillon::synth::modal
