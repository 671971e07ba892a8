#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/run/common_tasks.hpp"
#include "mpi/task_board.hpp"

namespace carillon::dataset::run {

class RunState;

/// How much of a run's builds is there, what earlier runs made included.
class Tally {
 public:
  explicit Tally(const std::vector<BuildRun>& builds);

  /// Counts what the board has as done or failed before the run begins.
  void take_over(RunState& state, const mpi::TaskBoard& board);
  /// A task has ended.
  /// @param entry  its journal's
  void count(std::size_t build, const plan::BuildTask& task, const nlohmann::json& entry);

  /// `samples`, `objects` and `tasks`: how many there are, are done and have failed (`all`, `done`,
  /// `failed`); `bytes` of files.
  nlohmann::ordered_json to_json() const;
  /// "120 of 400 samples  3 of 8 objects  1 task failed  12.3 MB".
  std::string text() const;
  /// Done by this run.
  std::int64_t new_samples() const { return samples_.done - samples_before_; }

 private:
  struct Count {
    std::int64_t all = 0, done = 0, failed = 0;
  };
  /// An object's tasks.
  struct Object {
    std::int64_t open = 0;
    bool failed = false;
  };

  static nlohmann::ordered_json to_json(const Count& count);

  Count samples_, objects_, tasks_;
  std::uint64_t bytes_ = 0;
  std::int64_t samples_before_ = 0;
  std::vector<std::vector<Object>> by_build_;
};

}  // namespace carillon::dataset::run
