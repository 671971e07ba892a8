#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "core/error.hpp"
#include "core/trace.hpp"
#include "mpi/comm.hpp"
#include "mpi/failure.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/patience.hpp"
#include "mpi/task_service.hpp"

namespace carillon::mpi {

namespace {

/// One task on every rank of its group, with the outcome that all of them agree on.
Outcome run_one(std::int64_t task, MPI_Comm group, const Work& work) {
  Outcome outcome;
  try {
    agreed(group, [&] { outcome.record = work(task, group); });
  } catch (...) {
    outcome = {false, to_record(describe(std::current_exception()))};
  }
  return outcome;
}

/// The leader's claim, for every rank of its group.
Claim next_of_group(TaskService& service, MPI_Comm group) {
  std::array<std::int64_t, 2> claimed{};
  if (rank(group) == 0) {
    const Claim claim = service.next(size(group));
    claimed = {static_cast<std::int64_t>(claim.kind), claim.task};
  }
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(claimed.data(), 2, MPI_INT64_T, 0, group, &request);
  wait_patiently(request);
  return {static_cast<Claim::Kind>(claimed[0]), claimed[1]};
}

/// Claims and runs tasks of the group's width until there are no more of them.
void run_group(TaskService& service, MPI_Comm group, const Work& work, RunReport& report) {
  for (;;) {
    // A signal may have reached any rank of the group, not only its leader.
    if (interrupt_requested()) service.stop();
    const Claim claim = next_of_group(service, group);
    if (claim.kind != Claim::Kind::task) return;
    const double start = core::monotonic_seconds();
    const Outcome outcome = run_one(claim.task, group, work);
    report.busy_seconds += core::monotonic_seconds() - start;
    ++report.tasks_run;
    if (rank(group) == 0) service.complete(claim.task, outcome);
  }
}

Comm split(MPI_Comm world, int color) {
  Comm group;
  MPI_Comm_split(world, color, rank(world), group.put());
  return group;
}

/// Rank 0 knows how the tasks ended; the others are told.
void fill_in_end(MPI_Comm world, TaskService::End end, RunReport& report) {
  std::array<std::int64_t, 4> counts{
      end.board.count(TaskState::done), end.board.count(TaskState::failed),
      end.board.count(TaskState::skipped), end.board.count(TaskState::waiting)};
  MPI_Bcast(counts.data(), static_cast<int>(counts.size()), MPI_INT64_T, 0, world);
  report.done = counts[0];
  report.failed = counts[1];
  report.skipped = counts[2];
  report.open = counts[3];
  // A signal that came when the last task had begun interrupted nothing.
  report.interrupted = end.stopped && report.open > 0;
  report.board = std::move(end.board);
}

}  // namespace

RunReport run_tasks(MPI_Comm world, TaskBoard board, ServiceHooks hooks, int group_width,
                    const Work& work) {
  agreed(world, [&] {
    if (group_width < 1) throw core::Error(fmt::format("groups of {} ranks", group_width));
    if (rank(world) == 0) board.set_group_width(std::min(group_width, size(world)));
  });
  const int width = std::min(group_width, size(world));
  const double start = core::monotonic_seconds();
  // Both kinds of group are made at once: later, no rank has to wait for another group's end.
  const int whole_groups = size(world) / width;
  const int place = rank(world) / width;
  const Comm group = split(world, width > 1 && place < whole_groups ? place : MPI_UNDEFINED);
  const Comm single = split(world, rank(world));

  TaskService service(world, std::move(board), std::move(hooks));
  RunReport report;
  if (group.get() != MPI_COMM_NULL) run_group(service, group.get(), work, report);
  run_group(service, single.get(), work, report);
  TaskService::End end = service.finish();
  report.idle_seconds = core::monotonic_seconds() - start - report.busy_seconds;
  fill_in_end(world, std::move(end), report);
  return report;
}

}  // namespace carillon::mpi
