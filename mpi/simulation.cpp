#include "mpi/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <queue>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "mpi/calibration.hpp"

namespace carillon::mpi {

namespace {

/// Neighbouring ranks that take tasks together.
struct Group {
  int first = 0;
  int width = 1;
  std::size_t level = 0;    ///< of its width among those of the board, the widest first
  int missing = 0;          ///< ranks that are still in a wider group
  double waits_since = 0;   ///< while it waits
  bool for_memory = false;  ///< why it waits
};

/// A group is free.
struct FreeGroup {
  double time = 0;
  std::int64_t number = 0;  ///< of the event, for those of the same time
  std::size_t group = 0;
  std::int64_t completed = -1;  ///< its task, or -1 where it has had none
  /// Greater means later, as std::priority_queue wants the first on top.
  bool operator<(const FreeGroup& other) const {
    return time != other.time ? time > other.time : number > other.number;
  }
};

void check(const TaskBoard& board, std::span<const double> seconds, const SimulatedRanks& on) {
  if (on.ranks < 1 || on.ranks_per_node < 1 || on.node_memory < 0) {
    throw core::Error(fmt::format("a schedule on {} ranks, {} on a node of {} bytes", on.ranks,
                                  on.ranks_per_node, on.node_memory));
  }
  if (seconds.size() != board.tasks().size()) {
    throw core::Error(fmt::format("{} times for {} tasks", seconds.size(), board.tasks().size()));
  }
  const auto wrong = [](double value) { return !(value >= 0) || !std::isfinite(value); };
  if (std::any_of(seconds.begin(), seconds.end(), wrong)) {
    throw core::Error("times of a schedule must be finite and not negative");
  }
}

class Simulation {
 public:
  Simulation(TaskBoard board, std::span<const double> seconds, const SimulatedRanks& on)
      : board_(std::move(board)),
        seconds_(seconds),
        on_(on),
        chains_(seconds.size(), 0),
        memory_(static_cast<std::size_t>((on.ranks - 1) / on.ranks_per_node + 1), 0) {
    board_.set_ranks(on.ranks, machine());
    for (const std::int64_t task : board_.fit_nowhere()) {
      if (board_.state(task) == TaskState::waiting) board_.mark_failed(task);
    }
    out_.refused = board_.count(TaskState::failed) + board_.count(TaskState::skipped);
    widths_ = board_.widths();
    for (std::size_t level = 0; level < widths_.size(); ++level) {
      first_of_level_.push_back(groups_.size());
      const int width = widths_[level];
      for (int first = 0; first + width <= on.ranks; first += width) {
        groups_.push_back({first, width, level, width});
      }
    }
    for (int rank = 0; rank < on.ranks; ++rank) join_from(0, rank, 0);
  }

  Schedule run() {
    while (!free_.empty()) {
      const FreeGroup event = free_.top();
      free_.pop();
      if (event.completed >= 0) complete(event);
      const Claim claim = ask(event.group, event.time);
      if (claim.kind == Claim::Kind::wait) {
        Group& group = groups_[event.group];
        group.waits_since = event.time;
        group.for_memory = claim.for_memory;
        waiting_[{group.width, on_.node_memory > 0 ? group.first / on_.ranks_per_node : 0}]
            .push_back(event.group);
      }
      if (event.completed >= 0) wake_waiting(event.time);
    }
    summarise();
    return out_;
  }

 private:
  /// The nodes, where their memory is bounded.
  Machine machine() const {
    Machine machine;
    if (on_.node_memory == 0) return machine;
    for (int rank = 0; rank < on_.ranks; ++rank) {
      machine.node_of_rank.push_back(rank / on_.ranks_per_node);
    }
    machine.memory.assign(memory_.size(), on_.node_memory);
    return machine;
  }

  /// A rank goes to its group of that level, or of the first narrower one that it is in: groups are
  /// neighbours, and ranks that are left over go on to the next width. The last to come asks.
  void join_from(std::size_t level, int rank, double time) {
    for (; level < widths_.size(); ++level) {
      const int place = rank / widths_[level];
      if (place >= on_.ranks / widths_[level]) continue;
      const std::size_t index = first_of_level_[level] + static_cast<std::size_t>(place);
      if (--groups_[index].missing == 0) free_.push({time, ++events_, index});
      return;
    }
  }

  /// A free group takes a task, or falls apart where none is left for it.
  Claim ask(std::size_t index, double now) {
    const Group group = groups_[index];
    const Claim claim = board_.claim(group.width, group.first);
    if (claim.kind == Claim::Kind::task) {
      const double end = now + seconds_[static_cast<std::size_t>(claim.task)];
      add_memory(group, claim.task, 1);
      at_work_.push_back({now, group.width});
      at_work_.push_back({end, -group.width});
      out_.task_time += group.width * (end - now);
      free_.push({end, ++events_, index, claim.task});
    } else if (claim.kind == Claim::Kind::end) {
      for (int r = 0; r < group.width; ++r) join_from(group.level + 1, group.first + r, now);
    }
    return claim;
  }

  void complete(const FreeGroup& ended) {
    const auto index = static_cast<std::size_t>(ended.completed);
    const Task& task = board_.tasks()[index];
    board_.complete(ended.completed, true);
    add_memory(groups_[ended.group], ended.completed, -1);
    for (const auto* earlier_ones : {&task.after, &task.behind}) {
      for (const std::int64_t earlier : *earlier_ones) {
        chains_[index] = std::max(chains_[index], chains_[static_cast<std::size_t>(earlier)]);
      }
    }
    chains_[index] += seconds_[index];
    out_.longest_chain = std::max(out_.longest_chain, chains_[index]);
    out_.last_task = ended.completed;
    out_.makespan = ended.time;
    correct_estimates(task, seconds_[index]);
  }

  /// By no more than the first thousand of a kind, whose median changes little afterwards.
  void correct_estimates(const Task& task, double seconds) {
    if (++ended_of_kind_[task.kind] > 1000) return;
    calibration_.add(task.kind, task.cost / task.width, seconds);
    board_.set_factor(task.kind, calibration_.factor(task.kind));
  }

  /// After a completion: those who wait find what it has set free, or that nothing is left.
  void wake_waiting(double now) {
    for (auto& [place, queue] : waiting_) {
      while (!queue.empty() && ask(queue.front(), now).kind != Claim::Kind::wait) {
        const Group& group = groups_[queue.front()];
        if (group.for_memory) out_.memory_wait += group.width * (now - group.waits_since);
        queue.pop_front();
      }
    }
  }

  void add_memory(const Group& group, std::int64_t task, int sign) {
    const double share = board_.tasks()[static_cast<std::size_t>(task)].memory / group.width;
    for (int r = group.first; r < group.first + group.width; ++r) {
      double& held = memory_[static_cast<std::size_t>(r / on_.ranks_per_node)];
      held += sign * share;
      out_.node_memory = std::max(out_.node_memory, held);
    }
  }

  void summarise() {
    const double available = on_.ranks * out_.makespan;
    if (available > 0) out_.efficiency = out_.task_time / available;
    out_.idle = available - out_.task_time;
    out_.shared_work = out_.task_time / on_.ranks;
    std::sort(at_work_.begin(), at_work_.end());
    int now = 0;
    for (std::size_t i = 0; i < at_work_.size();) {
      const double time = at_work_[i].first;
      const int before = now;
      // What happens at one time counts together: a rank may end one task and begin another.
      for (; i < at_work_.size() && at_work_[i].first == time; ++i) now += at_work_[i].second;
      if (before == on_.ranks && now < on_.ranks) out_.all_at_work_until = time;
      if (2 * before >= on_.ranks && 2 * now < on_.ranks) out_.half_at_work_until = time;
    }
  }

  TaskBoard board_;
  std::span<const double> seconds_;
  SimulatedRanks on_;
  Schedule out_;

  std::vector<int> widths_;  ///< of groups, descending
  std::vector<Group> groups_;
  std::vector<std::size_t> first_of_level_;
  Calibration calibration_;
  std::map<std::string, int> ended_of_kind_;
  std::priority_queue<FreeGroup> free_;
  std::int64_t events_ = 0;
  /// Groups told to wait, by width and, where memory is bounded, node: those of one place get the
  /// same answer.
  std::map<std::pair<int, int>, std::deque<std::size_t>> waiting_;
  std::vector<std::pair<double, int>> at_work_;  ///< when so many ranks more have a task
  std::vector<double> chains_;  ///< of each task that is done, the longest that ends with it
  std::vector<double> memory_;  ///< held on each node
};

}  // namespace

Schedule simulate(TaskBoard board, std::span<const double> seconds, const SimulatedRanks& on) {
  check(board, seconds, on);
  return Simulation(std::move(board), seconds, on).run();
}

}  // namespace carillon::mpi
