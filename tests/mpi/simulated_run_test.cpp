// Simulated schedules against real runs of the same tasks, which sleep and so need no core.
#include <gtest/gtest.h>

#include "core/trace.hpp"
#include "mpi/comm.hpp"
#include "mpi/simulation.hpp"
#include "mpi/task_service.hpp"
#include "tests/mpi/busy.hpp"

namespace carillon::mpi {
namespace {

const MPI_Comm world = MPI_COMM_WORLD;

TEST(SimulatedRun, TakesAsLongAsTheRealOne) {
  // Six shapes, each with modes and then three lots of samples; one of them is a straggler.
  std::vector<Task> tasks;
  std::vector<double> planned;
  for (std::int64_t i = 0; i < 24; ++i) {
    const bool modes = i < 6;
    planned.push_back(modes ? 0.02 + 0.01 * static_cast<double>(i) : i == 17 ? 0.25 : 0.05);
    Task task{.key = std::to_string(i), .cost = planned.back()};
    if (!modes) task.after = {i % 6};
    tasks.push_back(task);
  }
  std::vector<double> seconds(tasks.size(), 0);
  const bool host = rank(world) == 0;
  MPI_Barrier(world);
  const double start = core::monotonic_seconds();
  run_tasks(world, host ? TaskBoard(tasks) : TaskBoard(), {}, 1, [&](std::int64_t task, MPI_Comm) {
    const auto index = static_cast<std::size_t>(task);
    const double begin = core::monotonic_seconds();
    sleep_for(planned[index]);
    seconds[index] = core::monotonic_seconds() - begin;
    return "{}";
  });
  const double wall = core::monotonic_seconds() - start;
  MPI_Allreduce(MPI_IN_PLACE, seconds.data(), static_cast<int>(seconds.size()), MPI_DOUBLE, MPI_MAX,
                world);
  if (!host) return;
  const Schedule schedule =
      simulate(TaskBoard(tasks), seconds, {.ranks = size(world)},
               {.claim = 2e-5, .complete = 2e-5, .latency = 2e-3, .ask_again = 0.02});
  EXPECT_NEAR(schedule.makespan / wall, 1, 0.1) << schedule.makespan << " and " << wall;
}

}  // namespace
}  // namespace carillon::mpi
