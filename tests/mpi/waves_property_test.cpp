// Waves of groups on nodes of limited memory: random tasks, nodes and orders of events.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <vector>

#include "mpi/task_board.hpp"

namespace carillon::mpi {
namespace {

/// Ranks beside each other on nodes of one or more.
Machine random_machine(int ranks) {
  Machine machine;
  int node = -1;
  for (int rank = 0; rank < ranks; ++rank) {
    if (rank == 0 || *rc::gen::inRange(0, 3) == 0) {
      ++node;
      machine.memory.push_back(*rc::gen::inRange<std::int64_t>(0, 40));
    }
    machine.node_of_rank.push_back(node);
  }
  return machine;
}

std::vector<Task> random_tasks() {
  std::vector<Task> tasks;
  const int n = *rc::gen::inRange(0, 25);
  for (int i = 0; i < n; ++i) {
    Task task{.key = std::to_string(i),
              .cost = static_cast<double>(*rc::gen::inRange(0, 6)),
              .memory = static_cast<double>(*rc::gen::inRange(0, 50)),
              .width = *rc::gen::inRange(1, 5)};
    task.kind = *rc::gen::arbitrary<bool>() ? "modes" : "samples";
    if (i > 0 && *rc::gen::arbitrary<bool>()) {
      const std::int64_t before = *rc::gen::inRange(0, i);
      if (tasks[static_cast<std::size_t>(before)].width >= task.width) task.after = {before};
    }
    tasks.push_back(task);
  }
  return tasks;
}

/// What the tasks that run hold of each node, by adding up.
std::vector<std::int64_t> held_by(const std::vector<Task>& tasks, const Machine& machine,
                                  const std::vector<std::pair<std::int64_t, int>>& running) {
  std::vector<std::int64_t> held(machine.memory.size(), 0);
  for (const auto& [number, first] : running) {
    const Task& task = tasks[static_cast<std::size_t>(number)];
    const auto bytes = static_cast<std::int64_t>(task.memory);
    for (int rank = first; rank < first + task.width; ++rank) {
      held[static_cast<std::size_t>(machine.node_of_rank[static_cast<std::size_t>(rank)])] +=
          (bytes + task.width - 1) / task.width;
    }
  }
  return held;
}

/// A group on its way through the widths: busy with a task, or about to ask for one.
struct Group {
  int width, first;
  std::int64_t task = -1;
};

/// The group that a rank belongs to from its place in the list of widths on; width 0 at the end.
Group group_of(const std::vector<int>& widths, std::size_t& place, int rank, int ranks) {
  while (place < widths.size() && rank / widths[place] >= ranks / widths[place]) ++place;
  if (place == widths.size()) return {0, 0};
  return {widths[place], rank / widths[place] * widths[place]};
}

TEST(WavesProperty, NeverOverMemoryNeverStuckAndTheDearestThatFitsFirst) {
  const bool holds = rc::check([] {
    const int ranks = *rc::gen::inRange(1, 9);
    const Machine machine = random_machine(ranks);
    TaskBoard board(random_tasks());
    board.set_ranks(ranks, machine);
    for (const std::int64_t task : board.fit_nowhere()) {
      if (board.state(task) == TaskState::waiting) board.mark_failed(task);
    }
    const std::vector<Task>& tasks = board.tasks();
    const std::vector<int> widths = board.widths();
    std::map<std::string, double> factor{{"modes", 1}, {"samples", 1}};
    std::vector<std::size_t> place(static_cast<std::size_t>(ranks), 0);
    std::vector<std::pair<std::int64_t, int>> running;

    for (int step = 0; step < 20000; ++step) {
      // Groups whose ranks have all come, and are not busy, may ask.
      std::vector<Group> ready;
      bool all_at_end = true;
      for (int rank = 0; rank < ranks; ++rank) {
        const Group group = group_of(widths, place[static_cast<std::size_t>(rank)], rank, ranks);
        if (group.width == 0) continue;
        all_at_end = false;
        bool whole = rank == group.first;
        for (int other = group.first; other < group.first + group.width; ++other) {
          std::size_t at = place[static_cast<std::size_t>(other)];
          whole = whole && group_of(widths, at, other, ranks).width == group.width;
        }
        const bool busy = std::any_of(running.begin(), running.end(), [&](const auto& one) {
          return one.second == group.first &&
                 tasks[static_cast<std::size_t>(one.first)].width == group.width;
        });
        if (whole && !busy) ready.push_back(group);
      }
      if (all_at_end) break;
      if (!running.empty() && (ready.empty() || *rc::gen::arbitrary<bool>())) {
        const auto ended = *rc::gen::inRange<std::size_t>(0, running.size());
        board.complete(running[ended].first, *rc::gen::inRange(0, 5) > 0);
        running.erase(running.begin() + static_cast<std::ptrdiff_t>(ended));
        if (*rc::gen::inRange(0, 4) == 0) {
          factor["modes"] = *rc::gen::inRange(1, 5);
          board.set_factor("modes", factor["modes"]);
        }
        continue;
      }
      RC_ASSERT(!ready.empty());
      // With nothing running, one of the ready groups finds a task or an end: ask all in turn.
      bool moved = false;
      for (const Group& group : ready) {
        std::int64_t dearest = -1;
        double maximum = -1;
        for (std::size_t i = 0; i < tasks.size(); ++i) {
          const auto number = static_cast<std::int64_t>(i);
          const bool free =
              board.state(number) == TaskState::waiting && tasks[i].width == group.width &&
              std::all_of(tasks[i].after.begin(), tasks[i].after.end(), [&](std::int64_t before) {
                return board.state(before) == TaskState::done;
              });
          if (!free || factor[tasks[i].kind] * tasks[i].cost <= maximum) continue;
          auto with = running;
          with.emplace_back(number, group.first);
          const auto held = held_by(tasks, machine, with);
          bool fits = true;
          for (std::size_t node = 0; node < held.size(); ++node) {
            // Nodes of other groups do not count: they are as they were.
            fits = fits && held[node] <= machine.memory[node];
          }
          if (!fits) continue;
          dearest = number;
          maximum = factor[tasks[i].kind] * tasks[i].cost;
        }
        const Claim claim = board.claim(group.width, group.first);
        RC_ASSERT(claim.task == dearest);
        if (claim.kind == Claim::Kind::task) running.emplace_back(claim.task, group.first);
        if (claim.kind == Claim::Kind::end) {
          for (int rank = group.first; rank < group.first + group.width; ++rank) {
            ++place[static_cast<std::size_t>(rank)];
          }
        }
        const auto held = held_by(tasks, machine, running);
        RC_ASSERT(board.memory().held() == held);
        moved = claim.kind != Claim::Kind::wait;
        if (moved) break;
      }
      RC_ASSERT(moved || !running.empty());
    }
    RC_ASSERT(running.empty());
    RC_ASSERT(board.count(TaskState::waiting) == 0);
  });
  EXPECT_TRUE(holds);
}

}  // namespace
}  // namespace carillon::mpi
