#include "mpi/task_host.hpp"

#include <utility>

namespace carillon::mpi {

TaskHost::TaskHost(TaskBoard board, ServiceHooks hooks)
    : board_(std::move(board)), hooks_(std::move(hooks)) {}

template <class Act>
void TaskHost::guarded(Act&& act) {
  try {
    act();
  } catch (...) {
    if (!error_) error_ = std::current_exception();
    stopped_ = true;
  }
}

Claim TaskHost::claim(int width) {
  const std::scoped_lock lock(mutex_);
  if (stopped_) return {};
  Claim claim;
  guarded([&] {
    claim = board_.claim(width);
    if (claim.kind != Claim::Kind::task) return;
    const Task& task = board_.tasks()[static_cast<std::size_t>(claim.task)];
    if (hooks_.started) hooks_.started(task);
    if (hooks_.progress) hooks_.progress(board_);
  });
  return stopped_ ? Claim{} : claim;
}

void TaskHost::complete(std::int64_t task, const Outcome& outcome) {
  const std::scoped_lock lock(mutex_);
  // After an error of another hook too: what is finished should still reach the journal.
  guarded([&] {
    board_.complete(task, outcome.ok);
    if (hooks_.completed) {
      hooks_.completed(board_.tasks()[static_cast<std::size_t>(task)], outcome);
    }
    if (hooks_.progress) hooks_.progress(board_);
  });
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

TaskBoard TaskHost::board() const {
  const std::scoped_lock lock(mutex_);
  return board_;
}

}  // namespace carillon::mpi
