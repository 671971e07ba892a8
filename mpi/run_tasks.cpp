#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <vector>

#include "core/trace.hpp"
#include "mpi/backoff.hpp"
#include "mpi/comm.hpp"
#include "mpi/detail/work_clock.hpp"
#include "mpi/failure.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/task_service.hpp"

namespace carillon::mpi {

namespace {

/// One task on every rank of its group, with the outcome that all of them agree on.
Outcome run_one(std::int64_t task, MPI_Comm group, const Work& work) {
  Outcome outcome;
  try {
    agree_at_end(group, error_of([&] { outcome.record = work(task, group); }));
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
  wait_idly(request);
  return {static_cast<Claim::Kind>(claimed[0]), claimed[1]};
}

/// A group's work on its leader; each rank's own elsewhere.
WorkClock sum_on_leader(WorkClock own, MPI_Comm group) {
  WorkClock sum = own;
  if (size(group) > 1) {
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ireduce(&own, &sum, 2, MPI_DOUBLE, MPI_SUM, 0, group, &request);
    wait_idly(request);
  }
  return sum;
}

/// Claims and runs tasks of the group's width until there are no more of them.
/// @param first  the group's leader, as a rank of world
/// @param begin  of the run, on this rank's clock
void run_group(TaskService& service, MPI_Comm group, int first, double begin, const Work& work,
               RunReport& report) {
  for (;;) {
    // A signal may have reached any rank of the group, not only its leader.
    if (interrupt_requested()) service.stop();
    const Claim claim = next_of_group(service, group);
    if (claim.kind != Claim::Kind::task) return;
    const double start = core::monotonic_seconds();
    const WorkClock before = work_clock();
    Outcome outcome = run_one(claim.task, group, work);
    const WorkClock spent = work_clock() - before;
    const double seconds = core::monotonic_seconds() - start;
    report.times.busy += seconds;
    report.times.cpu += spent.cpu;
    ++report.tasks_run;
    const WorkClock all = sum_on_leader(spent, group);
    outcome.times = {start - begin, seconds, all.cpu, all.queued, first, size(group)};
    if (rank(group) == 0) service.complete(claim.task, outcome);
  }
}

Comm split(MPI_Comm world, int color) {
  Comm group;
  MPI_Comm_split(world, color, rank(world), group.put());
  return group;
}

/// Widths of groups, as rank 0's board has them.
std::vector<int> shared_widths(MPI_Comm world, const TaskBoard& board) {
  std::ostringstream text;
  for (const int width : board.widths()) text << width << ' ';
  std::istringstream in(broadcast(text.str(), 0, world));
  std::vector<int> widths;
  for (int width = 0; in >> width;) widths.push_back(width);
  return widths;
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
  report.calibration = std::move(end.calibration);
}

}  // namespace

RunReport run_tasks(MPI_Comm world, TaskBoard board, ServiceHooks hooks, const Work& work,
                    const Machine& machine) {
  const double begin = core::monotonic_seconds();
  const WorkClock at_begin = work_clock();
  agreed(world, [&] {
    if (rank(world) == 0) board.set_ranks(size(world), machine);
  });
  // All groups are made at once: later, no rank has to wait for another group's end.
  struct Group {
    int first;
    Comm comm;
  };
  std::vector<Group> groups;
  for (const int width : shared_widths(world, board)) {
    const int place = rank(world) / width;
    const bool whole = place < size(world) / width;
    groups.push_back({place * width, split(world, whole ? place : MPI_UNDEFINED)});
  }

  TaskService service(world, std::move(board), std::move(hooks));
  RunReport report;
  for (const Group& group : groups) {
    if (group.comm.get() == MPI_COMM_NULL) continue;
    run_group(service, group.comm.get(), group.first, begin, work, report);
  }
  TaskService::End end = service.finish();
  report.times.queued = (work_clock() - at_begin).queued;
  report.times.peak_memory = peak_memory();
  report.times.idle = core::monotonic_seconds() - begin - report.times.busy;
  fill_in_end(world, std::move(end), report);
  return report;
}

}  // namespace carillon::mpi
