#include "mpi/task_host.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/progress.hpp"
#include "mpi/failure.hpp"

namespace carillon::mpi {

TaskHost::TaskHost(TaskBoard board, ServiceHooks hooks)
    : board_(std::move(board)), hooks_(std::move(hooks)) {
  guarded([&] { refuse_what_fits_nowhere(); });
}

template <class Act>
void TaskHost::guarded(Act&& act) {
  try {
    act();
  } catch (...) {
    if (!error_) error_ = std::current_exception();
    stopped_ = true;
  }
}

void TaskHost::refuse_what_fits_nowhere() {
  for (const std::int64_t number : board_.fit_nowhere()) {
    // One that depends on an earlier one of these was skipped with it.
    if (board_.state(number) != TaskState::waiting) continue;
    board_.mark_failed(number);
    const Task& task = board_.tasks()[static_cast<std::size_t>(number)];
    const Machine& machine = board_.memory().machine();
    const auto& nodes = machine.memory;
    Failure failure{
        "LimitError",
        fmt::format("an estimated {} on {} are more than any node has for it: the largest has {}",
                    core::human_binary_bytes(task.memory),
                    task.width == 1 ? "one rank" : fmt::format("{} ranks", task.width),
                    core::human_binary_bytes(
                        static_cast<double>(*std::max_element(nodes.begin(), nodes.end())))),
        "run with more memory (`ranks.memory_per_node` says how much a node has), or on more nodes "
        "for an object wide enough for several ranks; or ask for larger elements, fewer modes or a "
        "smaller `solver.memory_limit`"};
    if (machine.measured) {
      failure.hint = "that is what was free when the run began, so the same command tries again; " +
                     failure.hint;
      failure.lasting = false;
    }
    if (hooks_.completed) hooks_.completed(task, {false, to_record(failure)});
  }
}

Claim TaskHost::claim(int width, int first) {
  const std::scoped_lock lock(mutex_);
  if (stopped_) return {};
  Claim claim;
  guarded([&] {
    claim = board_.claim(width, first);
    if (claim.kind == Claim::Kind::task && hooks_.progress) hooks_.progress(board_);
  });
  return stopped_ ? Claim{} : claim;
}

void TaskHost::complete(std::int64_t task, const Outcome& outcome) {
  const std::scoped_lock lock(mutex_);
  // After an error of another hook too: what is finished should still reach the journal.
  guarded([&] {
    board_.complete(task, outcome.ok);
    const Task& ended = board_.tasks()[static_cast<std::size_t>(task)];
    if (outcome.ok) {
      calibration_.add(ended.kind, ended.cost / ended.width, outcome.times.seconds);
      board_.set_factor(ended.kind, calibration_.factor(ended.kind));
    }
    if (hooks_.completed) hooks_.completed(ended, outcome);
    if (!outcome.ok && hooks_.lost_with) end_with(ended, outcome);
    if (hooks_.progress) hooks_.progress(board_);
  });
}

/// Ends what a failure concerns beside the task that met it.
void TaskHost::end_with(const Task& failed, const Outcome& outcome) {
  for (const std::int64_t number : hooks_.lost_with(failed)) {
    if (board_.state(number) != TaskState::waiting) continue;
    board_.mark_failed(number);
    const Task& task = board_.tasks()[static_cast<std::size_t>(number)];
    if (hooks_.completed) hooks_.completed(task, {false, outcome.record});
  }
}

void TaskHost::stop() {
  const std::scoped_lock lock(mutex_);
  stopped_ = true;
}

bool TaskHost::stopped() const {
  const std::scoped_lock lock(mutex_);
  return stopped_;
}

std::exception_ptr TaskHost::error() const {
  const std::scoped_lock lock(mutex_);
  return error_;
}

Calibration TaskHost::calibration() const {
  const std::scoped_lock lock(mutex_);
  return calibration_;
}

TaskBoard TaskHost::board() const {
  const std::scoped_lock lock(mutex_);
  return board_;
}

}  // namespace carillon::mpi
