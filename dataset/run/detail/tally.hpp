#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dataset/run/common_tasks.hpp"
#include "mpi/task_board.hpp"

namespace carillon::dataset::run {

class RunState;

/// How much of a run's builds is there, what earlier runs made included.
class Tally {
 public:
  /// `builds` must outlive it.
  explicit Tally(const std::vector<BuildRun>& builds);

  /// Counts what the board has as done or failed before the run begins.
  void take_over(RunState& state, const mpi::TaskBoard& board);
  /// A task has ended.
  /// @param task   of the build's plan, not a copy
  /// @param entry  its journal's
  void count(std::size_t build, const plan::BuildTask& task, const nlohmann::json& entry);

  /// `samples`, `objects` and `tasks`: how many there are, are done and have failed (`all`, `done`,
  /// `failed`; samples whose object failed have, too); `bytes` of files.
  nlohmann::ordered_json to_json() const;
  /// "120 of 400 samples  22.3 samples/s  3 of 8 objects  1 task failed  12.3 MB".
  /// @param elapsed_s  since this run began
  std::string text(double elapsed_s) const;
  /// Samples of this run [1/s]; nothing before the first.
  std::optional<double> rate(double elapsed_s) const;

 private:
  struct Count {
    std::int64_t all = 0, done = 0, failed = 0;
  };
  /// An object's tasks.
  struct Object {
    std::int64_t open = 0;
    bool failed = false;
    std::vector<std::size_t> samples;  ///< tasks that need its modes
  };
  struct Build {
    std::vector<Object> objects;
    std::vector<bool> settled;  ///< tasks whose samples are done or failed
  };

  static nlohmann::ordered_json to_json(const Count& count);
  void settle_samples(std::size_t build, std::size_t task, bool ok);

  Count samples_, objects_, tasks_;
  std::uint64_t bytes_ = 0;
  std::int64_t samples_before_ = 0;
  const std::vector<BuildRun>& runs_;
  std::vector<Build> builds_;
};

}  // namespace carillon::dataset::run
