// Simulated schedules against real runs of the same tasks, which sleep and so need no core.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/trace.hpp"
#include "mpi/comm.hpp"
#include "mpi/simulation.hpp"
#include "mpi/task_service.hpp"
#include "tests/mpi/busy.hpp"

namespace carillon::mpi {
namespace {

const MPI_Comm world = MPI_COMM_WORLD;

/// Six shapes, each with modes and then three lots of samples; one of them is a straggler.
struct Example {
  std::vector<Task> tasks;
  std::vector<double> seconds;
};

Example example() {
  Example out;
  for (std::int64_t i = 0; i < 24; ++i) {
    const bool modes = i < 6;
    out.seconds.push_back(modes ? 0.04 + 0.02 * static_cast<double>(i) : i == 17 ? 0.5 : 0.1);
    Task task{.key = std::to_string(i), .cost = out.seconds.back()};
    if (!modes) task.after = {i % 6};
    out.tasks.push_back(task);
  }
  return out;
}

/// What a rank waits from question to answer on this machine now: half of the median time between
/// two tasks of a rank, which is a completion and a claim.
double latency_of(const std::vector<double>& begins, const std::vector<double>& ends,
                  const std::vector<int>& owners) {
  std::vector<double> gaps;
  for (std::size_t next = 0; next < begins.size(); ++next) {
    double before = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (owners[i] == owners[next] && ends[i] <= begins[next]) before = std::max(before, ends[i]);
    }
    if (before > 0 && owners[next] != 0) gaps.push_back(begins[next] - before);
  }
  std::sort(gaps.begin(), gaps.end());
  return gaps.empty() ? 0 : gaps[gaps.size() / 2] / 2;
}

/// Of every rank, where the others have zero.
template <class Value>
void merge(std::vector<Value>& values, MPI_Datatype type) {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), type, MPI_MAX, world);
}

/// Simulated over real time of one run, by the times that its tasks took; the same on every rank.
double simulated_over_real() {
  const Example plan = example();
  const std::size_t n = plan.tasks.size();
  std::vector<double> begins(n, 0), ends(n, 0), seconds(n, 0);
  std::vector<int> owners(n, 0);
  MPI_Barrier(world);
  const double start = core::monotonic_seconds();
  run_tasks(world, rank(world) == 0 ? TaskBoard(plan.tasks) : TaskBoard(), {},
            [&](std::int64_t task, MPI_Comm) {
              const auto index = static_cast<std::size_t>(task);
              owners[index] = rank(world);
              begins[index] = core::monotonic_seconds();
              sleep_for(plan.seconds[index]);
              ends[index] = core::monotonic_seconds();
              return "{}";
            });
  double wall = core::monotonic_seconds() - start;
  MPI_Bcast(&wall, 1, MPI_DOUBLE, 0, world);
  merge(begins, MPI_DOUBLE);
  merge(ends, MPI_DOUBLE);
  merge(owners, MPI_INT);
  for (std::size_t i = 0; i < n; ++i) seconds[i] = ends[i] - begins[i];
  const Schedule schedule = simulate(TaskBoard(plan.tasks), seconds, {.ranks = size(world)},
                                     {.claim = 2e-5,
                                      .complete = 2e-5,
                                      .latency = latency_of(begins, ends, owners),
                                      .ask_again = 0.02});
  return schedule.makespan / wall;
}

TEST(SimulatedRun, TakesAsLongAsTheRealOne) {
  // Other programs can only make the real run longer: the best of a few counts.
  double ratio = 0;
  for (int attempt = 0; attempt < 5 && std::abs(ratio - 1) > 0.1; ++attempt) {
    ratio = simulated_over_real();
  }
  EXPECT_NEAR(ratio, 1, 0.1);
}

}  // namespace
}  // namespace carillon::mpi
