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
#include "mpi/idle_ranks.hpp"

namespace carillon::mpi {

namespace {

/// Neighbouring ranks that take tasks together.
struct Group {
  int first = 0;
  int width = 1;
  std::size_t level = 0;    ///< of its width among those of the board, the widest first
  int missing = 0;          ///< ranks that are still in a wider group
  double free_since = 0;    ///< the end of its last task, or when the last of its ranks came
  bool for_memory = false;  ///< why it waits
};

/// A message of a group's leader that reaches the host.
struct SimulatedRequest {
  double time = 0;
  std::int64_t number = 0;  ///< in the order of sending, for those of the same time
  std::size_t group = 0;
  std::int64_t completed = -1;  ///< the task, or -1 for a question for one
  /// Greater means later, as std::priority_queue wants the first on top.
  bool operator<(const SimulatedRequest& other) const {
    return time != other.time ? time > other.time : number > other.number;
  }
};

void check(const TaskBoard& board, std::span<const double> seconds, const SimulatedRanks& on,
           const ServiceCosts& costs) {
  if (on.ranks < 1 || on.ranks_per_node < 1 || on.node_memory < 0) {
    throw core::Error(fmt::format("a schedule on {} ranks, {} on a node of {} bytes", on.ranks,
                                  on.ranks_per_node, on.node_memory));
  }
  if (seconds.size() != board.tasks().size()) {
    throw core::Error(fmt::format("{} times for {} tasks", seconds.size(), board.tasks().size()));
  }
  const auto wrong = [](double value) { return !(value >= 0) || !std::isfinite(value); };
  if (std::any_of(seconds.begin(), seconds.end(), wrong) || wrong(costs.claim) ||
      wrong(costs.complete) || wrong(costs.latency) || wrong(costs.ask_again)) {
    throw core::Error("times of a schedule must be finite and not negative");
  }
}

class Simulation {
 public:
  Simulation(TaskBoard board, std::span<const double> seconds, const SimulatedRanks& on,
             const ServiceCosts& costs)
      : board_(std::move(board)),
        seconds_(seconds),
        on_(on),
        costs_(costs),
        chains_(seconds.size(), 0),
        memory_(static_cast<std::size_t>((on.ranks - 1) / on.ranks_per_node + 1), 0) {
    board_.set_ranks(on.ranks, machine());
    for (const std::int64_t task : board_.fit_nowhere()) {
      if (board_.state(task) == TaskState::waiting) board_.mark_failed(task);
    }
    refused_ = board_.count(TaskState::failed) + board_.count(TaskState::skipped);
    widths_ = board_.widths();
    if (widths_.empty()) widths_ = {1};
    first_of_level_.resize(widths_.size());
    for (std::size_t level = 0; level < widths_.size(); ++level) {
      first_of_level_[level] = groups_.size();
      const int width = widths_[level];
      for (int first = 0; first + width <= on.ranks; first += width) {
        groups_.push_back({first, width, level, width});
      }
    }
    for (int rank = 0; rank < on.ranks; ++rank) join_from(0, rank, 0, 0);
  }

  Schedule run() {
    while (!requests_.empty()) {
      const SimulatedRequest request = requests_.top();
      requests_.pop();
      serve(request);
    }
    return summary();
  }

 private:
  /// The host asks itself without a message.
  double latency(std::size_t group) const { return groups_[group].first == 0 ? 0 : costs_.latency; }

  void send(std::size_t group, double time, std::int64_t completed) {
    requests_.push({time, ++sent_, group, completed});
  }

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
  /// @param free  when its last task ended
  void join_from(std::size_t level, int rank, double time, double free) {
    for (; level < widths_.size(); ++level) {
      const int place = rank / widths_[level];
      if (place >= on_.ranks / widths_[level]) continue;
      const std::size_t index = first_of_level_[level] + static_cast<std::size_t>(place);
      Group& group = groups_[index];
      group.free_since = std::max(group.free_since, time);
      if (--group.missing == 0) send(index, group.free_since + latency(index) / 2, -1);
      return;
    }
    idle_.add(1, free);
  }

  void serve(const SimulatedRequest& request) {
    count_repeats(request.time);
    // Where those who wait ask faster than the host can answer, everybody queues.
    const double crowded =
        std::max(0.0, static_cast<double>(waiting_) * costs_.claim - costs_.ask_again);
    const double start = std::max(request.time + (costs_.ask_again > 0 ? crowded : 0), host_free_);
    const bool question = request.completed < 0;
    host_free_ = start + (question ? costs_.claim : costs_.complete);
    host_busy_ += host_free_ - start;
    ++answered_;
    const double answer = host_free_ - request.time + latency(request.group);
    answers_ += answer;
    ++timed_answers_;
    longest_answer_ = std::max(longest_answer_, answer);
    const double now = host_free_;
    if (question) {
      act(ask_board(request.group), request.group, now);
      return;
    }
    groups_[request.group].free_since = request.time - latency(request.group) / 2;
    finish(request.completed, request.group);
    board_.complete(request.completed, true);
    send(request.group, now + latency(request.group), -1);
    wake_waiting(now);
  }

  Claim ask_board(std::size_t group) {
    return board_.claim(groups_[group].width, groups_[group].first);
  }

  /// What a group does with the answer to its question.
  void act(const Claim& claim, std::size_t index, double now) {
    const Group group = groups_[index];
    switch (claim.kind) {
      case Claim::Kind::task: {
        add_memory(group, claim.task, 1);
        const double seconds = seconds_[static_cast<std::size_t>(claim.task)];
        task_time_ += seconds * group.width;
        send(index, now + latency(index) + seconds, claim.task);
        return;
      }
      case Claim::Kind::wait:
        idle_.add(group.width, group.free_since);
        groups_[index].for_memory = claim.for_memory;
        waiting_groups_[{group.width, on_.node_memory > 0 ? group.first / on_.ranks_per_node : 0}]
            .push_back(index);
        ++waiting_;
        return;
      case Claim::Kind::end:
        const double heard = now + latency(index) / 2;
        end_ = std::max(end_, heard);
        for (int r = 0; r < group.width; ++r) {
          join_from(group.level + 1, group.first + r, heard, group.free_since);
        }
    }
  }

  void finish(std::int64_t task, std::size_t group) {
    add_memory(groups_[group], task, -1);
    const auto index = static_cast<std::size_t>(task);
    double before = 0;
    const Task& ended = board_.tasks()[index];
    for (const auto* earlier_ones : {&ended.after, &ended.behind}) {
      for (const std::int64_t earlier : *earlier_ones) {
        before = std::max(before, chains_[static_cast<std::size_t>(earlier)]);
      }
    }
    chains_[index] = before + seconds_[index];
    longest_chain_ = std::max(longest_chain_, chains_[index]);
    if (longest_ < 0 || seconds_[index] > seconds_[static_cast<std::size_t>(longest_)]) {
      longest_ = task;
    }
    last_ = task;
    correct_estimates(ended, seconds_[index]);
  }

  void correct_estimates(const Task& task, double seconds) {
    constexpr int enough = 1000;
    if (++ended_of_kind_[task.kind] > enough) return;
    calibration_.add(task.kind, task.cost / task.width, seconds);
    board_.set_factor(task.kind, calibration_.factor(task.kind));
  }

  /// After a completion: those who wait find what it has set free, or that nothing is left.
  void wake_waiting(double now) {
    for (auto& [place, queue] : waiting_groups_) {
      const double interval = costs_.ask_again / static_cast<double>(queue.size() + 1);
      for (double order = 1; !queue.empty(); ++order) {
        const std::size_t group = queue.front();
        const Claim claim = ask_board(group);
        if (claim.kind == Claim::Kind::wait) break;
        queue.pop_front();
        --waiting_;
        host_free_ += costs_.claim;
        host_busy_ += costs_.claim;
        ++answered_;
        const double found = std::max(host_free_, now + order * interval);
        idle_.add(-groups_[group].width, found);
        if (groups_[group].for_memory) {
          memory_wait_ += groups_[group].width * (found - groups_[group].free_since);
        }
        groups_[group].free_since = found;
        act(claim, group, found);
      }
    }
  }

  void count_repeats(double now) {
    if (costs_.ask_again > 0 && waiting_ > 0) {
      double rate = static_cast<double>(waiting_) / costs_.ask_again;
      if (costs_.claim > 0) rate = std::min(rate, 1 / costs_.claim);
      repeats_ += rate * std::max(0.0, now - counted_until_);
    }
    counted_until_ = std::max(counted_until_, now);
  }

  void add_memory(const Group& group, std::int64_t task, int sign) {
    const double share = board_.tasks()[static_cast<std::size_t>(task)].memory / group.width;
    for (int r = group.first; r < group.first + group.width; ++r) {
      double& held = memory_[static_cast<std::size_t>(r / on_.ranks_per_node)];
      held += sign * share;
      node_memory_ = std::max(node_memory_, held);
    }
  }

  Schedule summary() {
    Schedule out;
    out.makespan = end_;
    out.task_time = task_time_;
    const double available = on_.ranks * end_;
    if (available > 0) out.efficiency = task_time_ / available;
    out.refused = refused_;
    out.idle = available - task_time_;
    out.memory_wait = memory_wait_;
    out.shared_work = task_time_ / on_.ranks;
    out.longest_chain = longest_chain_;
    const IdleRanks::Moments moments = idle_.moments(on_.ranks);
    out.all_at_work_until = moments.all_until;
    out.half_at_work_until = moments.half_until;
    out.longest_task = longest_;
    out.last_task = last_;
    out.node_memory = node_memory_;
    out.requests = static_cast<double>(answered_);
    out.repeats = repeats_;
    out.host_busy = std::min(end_, host_busy_ + repeats_ * costs_.claim);
    if (timed_answers_ > 0) out.mean_answer = answers_ / static_cast<double>(timed_answers_);
    out.longest_answer = longest_answer_;
    return out;
  }

  TaskBoard board_;
  std::span<const double> seconds_;
  SimulatedRanks on_;
  ServiceCosts costs_;

  std::vector<int> widths_;  ///< of groups, descending
  std::vector<Group> groups_;
  std::vector<std::size_t> first_of_level_;
  std::int64_t refused_ = 0;
  Calibration calibration_;
  std::map<std::string, int> ended_of_kind_;
  std::priority_queue<SimulatedRequest> requests_;
  /// Groups told to wait, by width and, where memory is bounded, node: those of one place get the
  /// same answer.
  std::map<std::pair<int, int>, std::deque<std::size_t>> waiting_groups_;
  std::int64_t waiting_ = 0;
  std::int64_t sent_ = 0;
  double host_free_ = 0;  ///< when the host has answered what came so far

  IdleRanks idle_;
  std::vector<double> chains_;  ///< of each task that is done, the longest that ends with it
  std::vector<double> memory_;  ///< held on each node
  double node_memory_ = 0;
  double end_ = 0;
  double task_time_ = 0;
  double memory_wait_ = 0;
  double longest_chain_ = 0;
  std::int64_t longest_ = -1, last_ = -1;

  std::int64_t answered_ = 0, timed_answers_ = 0;
  double answers_ = 0, longest_answer_ = 0;
  double host_busy_ = 0;
  double repeats_ = 0, counted_until_ = 0;
};

}  // namespace

Schedule simulate(TaskBoard board, std::span<const double> seconds, const SimulatedRanks& on,
                  const ServiceCosts& costs) {
  check(board, seconds, on, costs);
  return Simulation(std::move(board), seconds, on, costs).run();
}

}  // namespace carillon::mpi
