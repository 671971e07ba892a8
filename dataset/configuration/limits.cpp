#include "dataset/configuration/limits.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <new>

#include "core/data_limit.hpp"
#include "core/error.hpp"
#include "core/failure.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "mpi/comm.hpp"
#include "mpi/process_memory.hpp"
#include "mpi/running_task.hpp"

namespace carillon::dataset::configuration {

using core::ConfigNode;
using core::Dimension;

namespace {

/// OpenBLAS takes its work space at the first product and tries for ever where it gets none: before
/// any limit, then. It keeps what it has.
void wake_blas() {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Constant(128, 128, 1);
  Eigen::MatrixXd product(128, 128);
  product.noalias() = a * a;
  if (product(0, 0) != 128) throw core::Error("BLAS cannot multiply");
}

[[noreturn]] void refuse_memory(std::int64_t limit) {
  throw core::MemoryError(
      fmt::format("out of memory: the solve needs more than the limit of {}",
                  core::human_binary_bytes(static_cast<double>(limit))),
      "raise limits.solve_memory, or use a coarser mesh (modes.element_size, modes.order), a lower "
      "band or a lower solver.memory_limit, beyond which solves are iterative");
}

/// How long after a limit a part that does not heed it is ended.
double grace(double limit) {
  return std::max(2.0, 0.5 * limit);
}

}  // namespace

TaskLimits read_limits(ConfigNode node) {
  TaskLimits limits;
  limits.mesh.seconds = node.positive("mesh_time", Dimension::time, limits.mesh.seconds);
  const double mesh_memory =
      node.quantity("mesh_memory", Dimension::memory, static_cast<double>(limits.mesh.memory));
  core::at_key(node, "mesh_memory", [&] { limits.mesh.memory = core::whole_bytes(mesh_memory); });
  limits.solve_time = node.not_negative("solve_time", Dimension::time, 0);
  const double solve_memory = node.quantity("solve_memory", Dimension::memory, 0);
  if (solve_memory != 0) {
    core::at_key(node, "solve_memory",
                 [&] { limits.solve_memory = core::whole_bytes(solve_memory); });
  }
  limits.sample_time = node.not_negative("sample_time", Dimension::time, 0);
  return limits;
}

core::TimeLimit solve_clock(const TaskLimits& limits) {
  return {limits.solve_time, "the solve", "limits.solve_time"};
}

core::TimeLimit sample_clock(const TaskLimits& limits) {
  return {limits.sample_time, "the sound", "limits.sample_time"};
}

void within_memory(std::int64_t limit, const std::function<void()>& solve) {
  if (limit > 0) wake_blas();
  // Libraries that cannot even begin tend to crash.
  if (limit > 0 && mpi::process_memory().data >= limit) refuse_memory(limit);
  try {
    const core::DataLimit data(limit);
    solve();
  } catch (const std::bad_alloc&) {
    if (limit > 0) refuse_memory(limit);
    throw;
  } catch (const core::MemoryError&) {
    if (limit > 0) refuse_memory(limit);
    throw;
  }
}

void watch_task(mpi::RunningTask& running, const TaskLimits& limits, const std::string& task,
                core::Trace& trace, MPI_Comm group, const std::function<void()>& work) {
  std::string part, item;
  trace.on_enter = [&](const std::string& now, const std::string& of) {
    part = now;
    item = of;
    const core::TimeLimit clock = part == "solve" ? solve_clock(limits) : sample_clock(limits);
    const bool limited = clock.seconds > 0 && (part == "solve" || part == "sound");
    running.enter(part, item, limited ? clock.seconds + grace(clock.seconds) : 0,
                  limited ? clock.message() : "");
  };
  running.begin(task);
  // It stays noted until all of the group are here: who waits in vain ends as a crash of the task.
  const std::exception_ptr ended = mpi::error_of([&] {
    mpi::agree_at_end(group, mpi::error_of([&] {
                        try {
                          work();
                        } catch (...) {
                          core::Failure failure = core::describe(std::current_exception());
                          if (failure.stage.empty()) {
                            failure.stage = part;
                            failure.item = item;
                          }
                          throw core::TaskError(std::move(failure));
                        }
                      }));
  });
  running.end();
  trace.on_enter = nullptr;
  if (ended) std::rethrow_exception(ended);
}

}  // namespace carillon::dataset::configuration
