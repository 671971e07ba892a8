#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "dataset/run/detail/index_keeper.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::dataset::run {

/// What a finished or interrupted build says.
struct Summary {
  std::string output;
  std::size_t shapes = 0, samples = 0;
  std::int64_t tasks_run = 0;
  std::size_t failed = 0;
  bool interrupted = false;
  std::vector<std::string> missed{};  ///< shapes that did not meet the pitch target

  int exit_code() const;
};

/// On standard output, for a person or as one JSON document.
void print(const Summary& summary, bool as_json);

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
