#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mpi/task_service.hpp"

namespace carillon::dataset::plan {

/// A finished task's time, as the journal (an entry's `times`) and the trace (`tasks`) keep it.
struct TaskRow {
  std::string task{};   ///< its key
  std::string kind{};   ///< as mpi::Task::kind
  int run = 0;          ///< number of the run that did it
  double estimate = 0;  ///< [s] for its group, before the build began
  mpi::TaskTimes times{};
};

/// `{run, kind, estimate_s, seconds, cpu_s, queued_s, rank, width, start_s}`, as the journal's
/// entry has it, which names the task itself.
nlohmann::json to_json(const TaskRow& row);
/// The trace's `tasks`: the same with the key as `task`.
nlohmann::json to_json(const std::vector<TaskRow>& rows);

/// What to_json() wrote of a task. What earlier versions did not write is 0.
TaskRow task_row(const std::string& task, const nlohmann::json& times);
/// The `tasks` of a trace.json.
std::vector<TaskRow> task_rows(const nlohmann::json& trace);
/// Those of every finished task, in the order they began.
/// @param finished  journal entries by task
std::vector<TaskRow> task_rows(const std::map<std::string, nlohmann::json>& finished);

/// Number of the run that begins: 1 in a new folder, else one more than any in its journal.
int next_run(const std::vector<nlohmann::json>& journal);

/// How busy the ranks were until the last task began: seconds that processors computed for tasks,
/// over these and the time that ranks had no task, or waited for others of their group, and yet
/// could have had a processor. Waiting that spins, inside PETSc and MUMPS, counts as computing.
/// What other programs take of the machine does not count, neither in tasks nor between them. After
/// that moment ranks may well have nothing to do.
/// @param ranks  of this run
/// @return 1 where no time passed
double busy_fraction(const std::vector<TaskRow>& rows, int run,
                     const std::vector<mpi::RankTimes>& ranks);

/// The stricter share: seconds that processors computed for tasks until the last one began, over
/// all the time that the ranks had until then, but for what other programs took of it. Whatever a
/// task waits for (the disk, another thread) counts as not busy, in it or between tasks.
/// @return 1 where no time passed
double computing_fraction(const std::vector<TaskRow>& rows, int run,
                          const std::vector<mpi::RankTimes>& ranks);

/// What a run says of itself.
struct RunRecord {
  int run = 1;
  std::vector<mpi::RankTimes> ranks{};
  double busy_fraction = 1;
  std::optional<double> computing_fraction{};
  std::map<std::string, mpi::Calibration::Report> estimates{};  ///< by kind of task
  nlohmann::json made{};                                        ///< of mpi::made_by()
};

/// The trace's `ranks`: a list of `{busy_s, idle_s, cpu_s, queued_s, peak_memory_bytes}`.
nlohmann::json to_json(const std::vector<mpi::RankTimes>& ranks);
/// The trace's entry of a run: `{run, ranks, busy_fraction, computing_fraction,
/// estimates: {KIND: {tasks, before: {median, spread}, after: {median, spread}}}, made}`.
nlohmann::json to_json(const RunRecord& run);
/// For a person: a line for the ranks, one for what each of them was idle, and one for each kind of
/// task.
std::string run_text(const RunRecord& run);

/// The last of `runs` in a trace.json; nothing where there is none, or it cannot be read.
std::optional<RunRecord> last_run(const std::filesystem::path& trace);

/// Every rank's times, in rank order, on rank 0; empty on others.
/// @note Collective on world.
std::vector<mpi::RankTimes> gather_times(const mpi::RankTimes& times, MPI_Comm world);

}  // namespace carillon::dataset::plan
