#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

#include "dataset/run/detail/index_keeper.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::dataset::run {

/// What the host still does when SIGINT or SIGTERM ends a build in the middle of its tasks: the
/// index gets everything that is done, and the summary is printed. Nothing is recorded after that.
class LastWords {
 public:
  /// What is done, by build, and how many tasks of this run are among it.
  using Tell = std::function<void(const std::vector<Results>&, std::int64_t tasks_run)>;

  /// @param index  null on other ranks, which say nothing, and where nothing is left to do
  /// @param tell   says so on standard output
  LastWords(IndexKeeper* index, Tell tell) : index_(index), tell_(std::move(tell)) {}

  /// Records that a task has ended, by `record`.
  void count(const std::function<void()>& record);
  /// The run came to its end by itself: nothing is said any more.
  void keep();
  mpi::InterruptGuard::Leaving leaving();

 private:
  void say();

  IndexKeeper* index_;
  Tell tell_;
  std::int64_t tasks_run_ = 0;
  bool kept_ = false;
  std::mutex mutex_;
};

}  // namespace carillon::dataset::run
