#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "dataset/run/common_tasks.hpp"
#include "dataset/run/detail/attempts.hpp"
#include "dataset/run/detail/index_keeper.hpp"
#include "dataset/run/detail/task_inputs.hpp"
#include "mpi/journal.hpp"
#include "mpi/task_board.hpp"

namespace carillon::dataset::run {

/// The journals of builds; of more than a process may hold open, those at hand are.
class Journals {
 public:
  explicit Journals(const std::vector<BuildRun>& builds) : builds_(builds) {}

  mpi::Journal& of(std::size_t build);
  void close() { open_.clear(); }

 private:
  const std::vector<BuildRun>& builds_;
  std::map<std::size_t, std::unique_ptr<mpi::Journal>> open_;
};

/// What is known of a run's builds: whose their folders are, what is done in them, what is left to
/// do, and what becomes of it. Tasks have their numbers on the common board. Every rank has one;
/// journals and standings are the host's.
class RunState {
 public:
  struct Place {
    std::size_t build;
    const plan::BuildTask& task;
  };

  /// `builds` must outlive it.
  explicit RunState(const std::vector<BuildRun>& builds);

  /// Takes the folders over: claims them, counts what ended earlier runs against their tasks, drops
  /// what is damaged.
  /// @param output  where ranks of earlier runs noted what they ran
  /// @return on the host what is left to do, on one board
  /// @throws ConfigError  a folder of another configuration, before anything is written into any
  /// @note Collective on world.
  mpi::TaskBoard take_over(const std::filesystem::path& output, const OrderTasks& order,
                           bool retry_failed, MPI_Comm world);

  Place place_of(std::int64_t number) const;
  std::int64_t number_of(const std::string& key) const { return numbers_.at(key); }
  /// Hash of what decides a task.
  std::string inputs_of(std::int64_t number) const;
  /// Of a task that continues a shard: samples that are there. The same on every rank.
  std::size_t kept_samples(std::int64_t number) const;
  /// 1, 2, ...: as journals and traces count.
  int run() const { return run_; }

  /// A task has ended: into its build's journal, and what is known of it.
  /// @param entry  as a journal has it, but for what is this task's alone
  /// @return the entry
  const nlohmann::json& record(std::int64_t number, nlohmann::json entry);
  /// Tasks that a failure concerns beside the one that met it.
  std::vector<std::int64_t> lost_with(std::int64_t number) const;
  /// Journal entries of a build's tasks that ended, by key.
  std::map<std::string, nlohmann::json>& finished(std::size_t build) {
    return standings_[build].finished;
  }

 private:
  void claim_folders();
  void settle_earlier_attempts(const std::filesystem::path& output, MPI_Comm world);
  mpi::TaskBoard make_board(const OrderTasks& order, bool retry_failed);
  bool is_settled(std::size_t build, const std::string& task, bool ok) const;
  void mark_settled(mpi::TaskBoard& board, std::size_t build, bool retry_failed) const;
  std::vector<std::int64_t> numbers_of(std::vector<std::string> Attempts::*which) const;
  void mark_given_up(mpi::TaskBoard& board) const;
  void give_up_alike(mpi::TaskBoard& board);
  void share_kept_samples(MPI_Comm world);

  const std::vector<BuildRun>& builds_;
  std::vector<std::size_t> first_;  ///< as CommonTasks::first
  std::vector<TaskInputs> inputs_;  ///< by build
  /// By build and key.
  std::vector<std::map<std::string, std::size_t>> kept_samples_;

  // The host's.
  std::unordered_map<std::string, std::int64_t> numbers_;  ///< on the board, by key there
  SameWork same_work_;
  std::vector<Attempts> attempts_;  ///< by build
  std::vector<Standing> standings_;
  Journals journals_;
  int run_ = 1;
};

}  // namespace carillon::dataset::run
