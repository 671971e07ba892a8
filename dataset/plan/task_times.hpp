#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mpi/task_service.hpp"

namespace carillon::dataset::plan {

/// What the journal keeps of a task's time: `{run, kind, estimate_s, seconds, cpu_s, queued_s,
/// rank, width, start_s}`. `estimate_s` is what was estimated before the build began, for the
/// group.
nlohmann::json describe_times(const mpi::Task& task, const mpi::TaskTimes& times, int run);

/// Number of the run that begins: 1 in a new folder, else one more than any in its journal.
int next_run(const std::vector<nlohmann::json>& journal);

/// The trace's `tasks`: what describe_times() wrote of every finished task, with its key as `task`,
/// in the order they began.
nlohmann::json task_rows(const std::map<std::string, nlohmann::json>& finished);

/// How busy the ranks were until the last task began: seconds that processors computed for tasks,
/// over these and the time that ranks had no task, or waited for others of their group, and yet
/// could have had a processor. Waiting that spins, inside PETSc and MUMPS, counts as computing.
/// What other programs take of the machine does not count, neither in tasks nor between them. After
/// that moment ranks may well have nothing to do.
/// @param rows   of task_rows()
/// @param ranks  of this run
/// @return 1 where no time passed
double busy_fraction(const nlohmann::json& rows, int run, const std::vector<mpi::RankTimes>& ranks);

/// The stricter share: seconds that processors computed for tasks until the last one began, over
/// all the time that the ranks had until then, but for what other programs took of it. Whatever a
/// task waits for (the disk, another thread) counts as not busy, in it or between tasks.
/// @return 1 where no time passed
double computing_fraction(const nlohmann::json& rows, int run,
                          const std::vector<mpi::RankTimes>& ranks);

/// The trace's entry of a run: `{run, ranks: [{busy_s, idle_s, cpu_s, queued_s,
/// peak_memory_bytes}], busy_fraction, computing_fraction,
/// estimates: {KIND: {tasks, before: {median, spread}, after: {median, spread}}}}`.
nlohmann::json describe_run(int run, const std::vector<mpi::RankTimes>& ranks,
                            const mpi::Calibration& calibration, const nlohmann::json& rows);

/// `runs` of the trace that an earlier run left; empty where there is none, or it cannot be read.
nlohmann::json earlier_runs(const std::filesystem::path& trace);

/// A run's entry for a person: a line for the ranks, one for what each of them was idle, and one
/// for each kind of task.
std::string run_text(const nlohmann::json& run);

/// Every rank's times, in rank order, on rank 0; empty on others.
/// @note Collective on world.
std::vector<mpi::RankTimes> gather_times(const mpi::RankTimes& times, MPI_Comm world);

}  // namespace carillon::dataset::plan
