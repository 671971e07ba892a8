#pragma once

#include <utility>

namespace carillon::core {

/// Move-only owner of a C library's handle. `Destroy` takes a pointer to the handle, as PETSc,
/// SLEPc and MPI do; `Null` is the value that owns nothing.
template <class T, auto Destroy, auto Null = T{}>
class Handle {
 public:
  Handle() = default;
  explicit Handle(T raw) : raw_(raw) {}
  Handle(Handle&& other) noexcept : raw_(std::exchange(other.raw_, T(Null))) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(raw_, other.raw_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (raw_ != T(Null)) Destroy(&raw_);
  }

  T get() const { return raw_; }
  /// For creation functions that fill in the handle.
  T* put() { return &raw_; }
  /// Lets go of the handle, for those that take it over.
  T release() { return std::exchange(raw_, T(Null)); }

 private:
  T raw_ = T(Null);
};

}  // namespace carillon::core
