#include "cli/build/limits.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <fstream>
#include <new>

#include "cli/text.hpp"
#include "core/error.hpp"
#include "core/progress.hpp"
#include "mpi/failure.hpp"
#include "mpi/witness.hpp"

namespace carillon::cli {

using core::ConfigNode;
using core::Dimension;

namespace {

double limit_or_none(ConfigNode& node, const std::string& key) {
  const double seconds = node.quantity(key, Dimension::time, 0);
  if (!(seconds >= 0)) node.fail(key, "must not be negative; 0 is no limit");
  return seconds;
}

/// Data and stack of this process [byte]; 0 where it cannot be read.
std::int64_t data_bytes() {
  std::ifstream file("/proc/self/statm");
  std::int64_t size = 0, resident = 0, shared = 0, text = 0, libraries = 0, data = 0;
  if (!(file >> size >> resident >> shared >> text >> libraries >> data)) return 0;
  return data * sysconf(_SC_PAGESIZE);
}

/// OpenBLAS takes its work space at the first product and tries for ever where it gets none: before
/// any limit, then. It keeps what it has.
void wake_blas() {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Constant(128, 128, 1);
  Eigen::MatrixXd product(128, 128);
  product.noalias() = a * a;
  if (product(0, 0) != 128) throw core::Error("BLAS cannot multiply");
}

/// A soft limit on the data of this process, for one scope.
class DataLimit {
 public:
  explicit DataLimit(std::int64_t bytes) {
    if (bytes <= 0 || getrlimit(RLIMIT_DATA, &former_) != 0) return;
    const rlimit limit{std::min(static_cast<rlim_t>(bytes), former_.rlim_max), former_.rlim_max};
    set_ = setrlimit(RLIMIT_DATA, &limit) == 0;
  }
  ~DataLimit() {
    if (set_) setrlimit(RLIMIT_DATA, &former_);
  }
  DataLimit(const DataLimit&) = delete;
  DataLimit& operator=(const DataLimit&) = delete;

 private:
  rlimit former_{};
  bool set_ = false;
};

[[noreturn]] void refuse_memory(std::int64_t limit) {
  throw core::MemoryError(
      fmt::format("out of memory: the solve needs more than the limit of {}",
                  core::human_binary_bytes(static_cast<double>(limit))),
      "raise limits.solve_memory, or use a coarser mesh (modes.element_size, modes.order), a lower "
      "band or a lower solver.memory_limit, beyond which solves are iterative");
}

/// How long after a limit a part that does not heed it is ended.
double patience(double limit) {
  return std::max(2.0, 0.5 * limit);
}

}  // namespace

TaskLimits read_limits(ConfigNode node) {
  TaskLimits limits;
  limits.mesh.seconds = node.quantity("mesh_time", Dimension::time, limits.mesh.seconds);
  if (!(limits.mesh.seconds > 0)) node.fail("mesh_time", "must be positive");
  const double mesh_memory =
      node.quantity("mesh_memory", Dimension::memory, static_cast<double>(limits.mesh.memory));
  core::at_key(node, "mesh_memory", [&] { limits.mesh.memory = whole_bytes(mesh_memory); });
  limits.solve_time = limit_or_none(node, "solve_time");
  const double solve_memory = node.quantity("solve_memory", Dimension::memory, 0);
  if (solve_memory != 0) {
    core::at_key(node, "solve_memory", [&] { limits.solve_memory = whole_bytes(solve_memory); });
  }
  limits.sample_time = limit_or_none(node, "sample_time");
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
  if (limit > 0 && data_bytes() >= limit) refuse_memory(limit);
  try {
    const DataLimit data(limit);
    solve();
  } catch (const std::bad_alloc&) {
    if (limit > 0) refuse_memory(limit);
    throw;
  } catch (const core::MemoryError&) {
    if (limit > 0) refuse_memory(limit);
    throw;
  }
}

void watch_task(mpi::Witness& witness, const TaskLimits& limits, const std::string& task,
                core::Trace& trace, const std::function<void()>& work) {
  std::string part, item;
  trace.on_enter = [&](const std::string& now, const std::string& of) {
    part = now;
    item = of;
    const core::TimeLimit clock = part == "solve" ? solve_clock(limits) : sample_clock(limits);
    const bool limited = clock.seconds > 0 && (part == "solve" || part == "sound");
    witness.enter(part, item, limited ? clock.seconds + patience(clock.seconds) : 0,
                  limited ? clock.message() : "");
  };
  witness.begin(task);
  try {
    work();
  } catch (...) {
    witness.end();
    trace.on_enter = nullptr;
    mpi::Failure failure = mpi::describe(std::current_exception());
    if (failure.stage.empty()) {
      failure.stage = part;
      failure.item = item;
    }
    throw mpi::TaskError(std::move(failure));
  }
  witness.end();
  trace.on_enter = nullptr;
}

}  // namespace carillon::cli
