#pragma once

#include <mutex>

namespace carillon::core {

/// FFTW makes and destroys plans in one thread at a time; running them needs no lock.
inline std::mutex& fft_planner() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace carillon::core
