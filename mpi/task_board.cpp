#include "mpi/task_board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "core/error.hpp"

namespace carillon::mpi {

namespace {

void check_values(const Task& task) {
  if (task.width < 1) {
    throw core::Error(fmt::format("task '{}' wants {} ranks", task.key, task.width));
  }
  if (!std::isfinite(task.cost) || task.cost < 0 || !std::isfinite(task.memory) ||
      task.memory < 0) {
    throw core::Error(fmt::format("task '{}' has an estimate of {} s and {} bytes", task.key,
                                  task.cost, task.memory));
  }
}

std::vector<std::int64_t> waited_for(const Task& task) {
  std::vector<std::int64_t> all = task.after;
  all.insert(all.end(), task.behind.begin(), task.behind.end());
  return all;
}

bool is_settled(TaskState state) {
  return state == TaskState::done || state == TaskState::failed || state == TaskState::skipped;
}

}  // namespace

TaskBoard::TaskBoard(std::vector<Task> tasks)
    : tasks_(std::move(tasks)),
      states_(tasks_.size(), TaskState::waiting),
      unmet_(tasks_.size(), 0),
      dependents_(tasks_.size()),
      followers_(tasks_.size()) {
  check_dependencies();
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    for (const std::int64_t earlier : tasks_[i].after) {
      dependents_[static_cast<std::size_t>(earlier)].push_back(i);
    }
    for (const std::int64_t earlier : tasks_[i].behind) {
      followers_[static_cast<std::size_t>(earlier)].push_back(i);
    }
    unmet_[i] = static_cast<std::int64_t>(tasks_[i].after.size() + tasks_[i].behind.size());
  }
  check_order();
  counts_[static_cast<std::size_t>(TaskState::waiting)] = static_cast<std::int64_t>(tasks_.size());
  number_kinds();
  fill_queues();
}

void TaskBoard::check_dependencies() const {
  std::unordered_set<std::string> keys;
  for (const Task& task : tasks_) {
    check_values(task);
    if (!keys.insert(task.key).second) {
      throw core::Error(fmt::format("two tasks have the key '{}'", task.key));
    }
    for (const std::int64_t earlier : waited_for(task)) {
      if (earlier < 0 || earlier >= static_cast<std::int64_t>(tasks_.size())) {
        throw core::Error(fmt::format("task '{}' waits for task {}, but there are {} tasks",
                                      task.key, earlier, tasks_.size()));
      }
      const Task& before = tasks_[static_cast<std::size_t>(earlier)];
      if (before.width < task.width) {
        throw core::Error(
            fmt::format("task '{}' for {} ranks waits for the narrower task '{}' for {}", task.key,
                        task.width, before.key, before.width));
      }
    }
  }
}

void TaskBoard::check_order() const {
  // Take away tasks that wait for nothing (Kahn); what remains waits for itself.
  std::vector<std::int64_t> unmet = unmet_;
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < unmet.size(); ++i) {
    if (unmet[i] == 0) free.push_back(i);
  }
  std::size_t ordered = 0;
  while (!free.empty()) {
    const std::size_t task = free.back();
    free.pop_back();
    ++ordered;
    for (const auto* later_ones : {&dependents_[task], &followers_[task]}) {
      for (const std::size_t later : *later_ones) {
        if (--unmet[later] == 0) free.push_back(later);
      }
    }
  }
  if (ordered == tasks_.size()) return;
  // What is left holds the circles and what waits for them: going back from any of it along
  // dependencies that are left too must end on a circle.
  std::size_t task = 0;
  while (unmet[task] == 0) ++task;
  for (std::size_t steps = 0; steps < tasks_.size(); ++steps) {
    for (const std::int64_t earlier : waited_for(tasks_[task])) {
      if (unmet[static_cast<std::size_t>(earlier)] > 0) {
        task = static_cast<std::size_t>(earlier);
        break;
      }
    }
  }
  throw core::Error(
      fmt::format("task '{}' waits for itself, by a circle of tasks that wait for "
                  "each other",
                  tasks_[task].key));
}

void TaskBoard::number_kinds() {
  for (const Task& task : tasks_) {
    const auto [at, added] = kind_numbers_.emplace(task.kind, kinds_.size());
    if (added) kinds_.emplace_back();
    kind_of_.push_back(at->second);
    kinds_[at->second].total += task.cost;
  }
}

void TaskBoard::fill_queues() {
  queues_.clear();
  places_.assign(tasks_.size(), 0);
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    if (states_[i] != TaskState::waiting) continue;
    Queue& queue = queues_[tasks_[i].width];
    queue.waiting.insert(tasks_[i].memory);
    if (tasks_[i].alone) {
      queue.alone.insert(i);
    } else {
      line_of(i).order.push_back(i);
    }
  }
  for (auto& [width, queue] : queues_) {
    for (auto& [kind, line] : queue.lines) {
      std::stable_sort(line.order.begin(), line.order.end(), [&](std::size_t a, std::size_t b) {
        return tasks_[a].cost > tasks_[b].cost;
      });
      line.ready = ReadyTasks(line.order.size());
      for (std::size_t place = 0; place < line.order.size(); ++place) {
        const std::size_t task = line.order[place];
        places_[task] = place;
        if (unmet_[task] == 0) make_ready(task);
      }
    }
  }
}

void TaskBoard::make_ready(std::size_t task) {
  if (!tasks_[task].alone) line_of(task).ready.put(places_[task], tasks_[task].memory);
}

void TaskBoard::set_ranks(int ranks, const Machine& machine) {
  if (claimed_ || ranks < 1) {
    throw core::Error(
        fmt::format("{} ranks cannot be had{}", ranks, claimed_ ? " after the first claim" : ""));
  }
  if (!machine.node_of_rank.empty() &&
      machine.node_of_rank.size() != static_cast<std::size_t>(ranks)) {
    throw core::Error(
        fmt::format("nodes of {} ranks for {} of them", machine.node_of_rank.size(), ranks));
  }
  for (Task& task : tasks_) task.width = std::min(task.width, ranks);
  ranks_ = ranks;
  ledger_ = MemoryLedger(machine);
  fill_queues();
}

std::vector<std::int64_t> TaskBoard::fit_nowhere() const {
  std::vector<std::int64_t> out;
  for (std::size_t i = 0; i < tasks_.size() && ledger_.bounded(); ++i) {
    if (states_[i] != TaskState::waiting) continue;
    const int width = tasks_[i].width;
    bool fits = false;
    for (int first = 0; first + width <= ranks_ && !fits; first += width) {
      fits = ledger_.fits_alone(tasks_[i].memory, width, first);
    }
    if (!fits) out.push_back(static_cast<std::int64_t>(i));
  }
  return out;
}

std::vector<int> TaskBoard::widths() const {
  std::vector<int> widths;
  for (const auto& [width, queue] : queues_) {
    if (!queue.waiting.empty()) widths.insert(widths.begin(), width);
  }
  return widths;
}

void TaskBoard::set_factor(const std::string& kind, double factor) {
  if (!(factor > 0) || !std::isfinite(factor)) {
    throw core::Error(fmt::format("costs of kind '{}' times {}", kind, factor));
  }
  const auto found = kind_numbers_.find(kind);
  if (found != kind_numbers_.end()) kinds_[found->second].factor = factor;
}

double TaskBoard::sum_of(double Kind::*part) const {
  double sum = 0;
  for (const Kind& kind : kinds_) sum += kind.factor * (kind.*part);
  return sum;
}

void TaskBoard::mark_done(std::int64_t task) {
  const std::size_t index = checked(task);
  if (claimed_) {
    throw core::Error(fmt::format("task '{}' is marked after the first claim", tasks_[index].key));
  }
  if (states_[index] == TaskState::done) return;
  if (states_[index] != TaskState::waiting) {
    // Going back over what was skipped by mistake is spared by marking in the right order.
    throw core::Error(
        fmt::format("task '{}' is marked done after a failure it depends on", tasks_[index].key));
  }
  set_state(index, TaskState::done);
  release_dependents(index);
}

void TaskBoard::mark_failed(std::int64_t task) {
  const std::size_t index = checked(task);
  if (states_[index] == TaskState::done || states_[index] == TaskState::running) {
    throw core::Error(fmt::format("task '{}' is marked failed, but is {}", tasks_[index].key,
                                  states_[index] == TaskState::done ? "done" : "running"));
  }
  if (states_[index] == TaskState::failed) return;
  set_state(index, TaskState::failed);
  skip_dependents(index);
}

bool TaskBoard::waits_for_one_alone(int width) const {
  return one_runs_alone_ ||
         std::any_of(queues_.upper_bound(width), queues_.end(),
                     [](const auto& wider) { return !wider.second.alone.empty(); });
}

/// The first of a width that is to run alone and can do so now; -1 where there is none.
std::int64_t TaskBoard::next_alone(const Queue& queue, int width, int first) const {
  if (count(TaskState::running) > 0) return -1;
  for (const std::size_t task : queue.alone) {
    if (unmet_[task] == 0 && ledger_.fits(tasks_[task].memory, width, first))
      return static_cast<std::int64_t>(task);
  }
  return -1;
}

Claim TaskBoard::claim(int width, int first) {
  claimed_ = true;
  if (waits_for_one_alone(width)) return {Claim::Kind::wait};
  const auto found = queues_.find(width);
  if (found == queues_.end()) return {};
  Queue& queue = found->second;
  double dearest = -1;
  std::int64_t task = -1;
  for (const auto& [number, line] : queue.lines) {
    const std::size_t place =
        line.ready.first([&](double memory) { return ledger_.fits(memory, width, first); });
    if (place == ReadyTasks::none) continue;
    const auto candidate = static_cast<std::int64_t>(line.order[place]);
    const double cost = kinds_[number].factor * tasks_[line.order[place]].cost;
    if (cost < dearest || (cost == dearest && candidate > task)) continue;
    dearest = cost;
    task = candidate;
  }
  if (task < 0) task = next_alone(queue, width, first);
  if (task < 0) {
    // The least of what waits decides: what is too large here is another group's.
    const bool any =
        !queue.waiting.empty() && ledger_.fits_alone(*queue.waiting.begin(), width, first);
    const bool ready = std::any_of(queue.lines.begin(), queue.lines.end(), [](const auto& line) {
      return line.second.ready.first([](double) { return true; }) != ReadyTasks::none;
    });
    return {any ? Claim::Kind::wait : Claim::Kind::end, -1, any && ready};
  }
  const auto index = static_cast<std::size_t>(task);
  ledger_.take(tasks_[index].memory, width, first);
  first_of_[task] = first;
  one_runs_alone_ = tasks_[index].alone;
  set_state(index, TaskState::running);
  return {Claim::Kind::task, task};
}

void TaskBoard::complete(std::int64_t task, bool ok) {
  const std::size_t index = checked(task);
  if (states_[index] != TaskState::running) {
    throw core::Error(fmt::format("task '{}' is completed but was not running", tasks_[index].key));
  }
  const auto first = first_of_.find(task);
  ledger_.give_back(tasks_[index].memory, tasks_[index].width, first->second);
  first_of_.erase(first);
  one_runs_alone_ = false;
  set_state(index, ok ? TaskState::done : TaskState::failed);
  if (ok) {
    release_dependents(index);
  } else {
    skip_dependents(index);
  }
}

void TaskBoard::release(std::size_t task) {
  if (--unmet_[task] == 0 && states_[task] == TaskState::waiting) make_ready(task);
}

void TaskBoard::release_dependents(std::size_t task) {
  for (const std::size_t later : dependents_[task]) release(later);
}

void TaskBoard::skip_dependents(std::size_t task) {
  std::vector<std::size_t> reached{task};
  while (!reached.empty()) {
    const std::size_t lost = reached.back();
    reached.pop_back();
    for (const std::size_t later : dependents_[lost]) {
      // What is done already stays done, and so does what waits for it.
      if (states_[later] != TaskState::waiting) continue;
      set_state(later, TaskState::skipped);
      reached.push_back(later);
    }
  }
}

void TaskBoard::set_state(std::size_t task, TaskState state) {
  const TaskState before = states_[task];
  if (before == TaskState::waiting) {
    Queue& queue = queues_[tasks_[task].width];
    queue.waiting.erase(queue.waiting.find(tasks_[task].memory));
    if (tasks_[task].alone) {
      queue.alone.erase(task);
    } else {
      line_of(task).ready.take(places_[task]);
    }
  }
  if (is_settled(state) && !is_settled(before)) kinds_[kind_of_[task]].settled += tasks_[task].cost;
  --counts_[static_cast<std::size_t>(before)];
  ++counts_[static_cast<std::size_t>(state)];
  states_[task] = state;
  if (!is_settled(state) || is_settled(before)) return;
  for (const std::size_t later : followers_[task]) release(later);
}

std::size_t TaskBoard::checked(std::int64_t task) const {
  if (task < 0 || task >= static_cast<std::int64_t>(tasks_.size())) {
    throw core::Error(fmt::format("there is no task {} among {}", task, tasks_.size()));
  }
  return static_cast<std::size_t>(task);
}

TaskState TaskBoard::state(std::int64_t task) const {
  return states_[checked(task)];
}

std::int64_t TaskBoard::count(TaskState state) const {
  return counts_[static_cast<std::size_t>(state)];
}

}  // namespace carillon::mpi
