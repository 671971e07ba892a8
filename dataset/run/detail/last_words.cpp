#include "dataset/run/detail/last_words.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

namespace carillon::dataset::run {

void LastWords::count(const std::function<void()>& record) {
  const std::scoped_lock lock(mutex_);
  record();
  ++tasks_run_;
}

void LastWords::keep() {
  const std::scoped_lock lock(mutex_);
  kept_ = true;
}

mpi::InterruptGuard::Leaving LastWords::leaving() {
  mpi::InterruptGuard::Leaving leaving;
  if (index_ != nullptr) leaving.last_words = [this] { say(); };
  return leaving;
}

void LastWords::say() {
  // Most of the index while the program may still get out by itself, the rest and the summary when
  // that has become unlikely.
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds hope(200), to_spare(50);
  const auto begin = Clock::now();
  index_->write_now();
  // The second writing takes as long as the first, and must end within the grace as well.
  const Clock::duration latest =
      mpi::InterruptGuard::Leaving{}.grace - to_spare - (Clock::now() - begin);
  while (Clock::now() - begin < std::min<Clock::duration>(hope, latest)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const std::scoped_lock lock(mutex_);
    if (kept_) return;
  }
  mutex_.lock();
  if (kept_) {
    mutex_.unlock();
    return;
  }
  // Never unlocked: the process ends within the grace.
  const std::vector<Results> results = index_->write_now();
  if (tell_) tell_(results, tasks_run_);
  std::fflush(stdout);
}

}  // namespace carillon::dataset::run
