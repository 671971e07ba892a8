#include "eval/studies/detail/stage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>

#include "core/progress.hpp"
#include "core/storage_error.hpp"
#include "core/trace.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/task_service.hpp"

namespace carillon::eval::studies {

using nlohmann::json;

namespace {

/// Says once that the run was cut short, whether it ended by itself or was given up.
class LastLine {
 public:
  explicit LastLine(core::Tell tell) : tell_(std::move(tell)) {}
  void tell() {
    if (!tell_) return;
    std::call_once(told_, [this] {
      tell_("interrupted: run the same command to go on\n", {{"interrupted", true}});
      std::fflush(stdout);
    });
  }

 private:
  core::Tell tell_;
  std::once_flag told_;
};

}  // namespace

StageEnd run_stage(const Stage& stage, MPI_Comm world) {
  const bool host = mpi::rank(world) == 0;
  const double start = core::monotonic_seconds();
  mpi::TaskBoard board(host ? stage.tasks : std::vector<mpi::Task>{});
  std::map<std::string, std::int64_t> numbers;
  for (std::size_t t = 0; t < board.tasks().size(); ++t) {
    numbers[board.tasks()[t].key] = static_cast<std::int64_t>(t);
    if (stage.done[t]) board.mark_done(static_cast<std::int64_t>(t));
  }
  const bool idle = board.count(mpi::TaskState::waiting) == 0;
  const double expected = board.total_cost();
  core::Progress progress(stage.name, expected, !host || idle);
  StageEnd end;
  std::map<std::int64_t, json> failures;
  mpi::ServiceHooks hooks;
  hooks.completed = [&](const mpi::Task& task, const mpi::Outcome& ended) {
    json record = json::parse(ended.record);
    // A full disk is nobody's failure: nothing is recorded, and the run ends.
    if (!ended.ok && record.value("kind", "") == "StorageError") {
      throw core::StorageError(record.at("message"), record.value("hint", ""));
    }
    ++end.tasks_run;
    end.rank_seconds += ended.times.seconds;
    const std::int64_t number = numbers.at(task.key);
    if (ended.ok) {
      if (stage.completed) stage.completed(number, record);
    } else {
      record["task"] = task.key;
      failures[number] = std::move(record);
    }
  };
  hooks.progress = [&](const mpi::TaskBoard& now) {
    // Costs grow and shrink as tasks tell how long they take.
    progress.update(expected * now.settled_cost() / std::max(now.total_cost(), 1e-300),
                    fmt::format("{} of {}", now.count(mpi::TaskState::done), now.tasks().size()));
  };
  LastLine last_line(host ? stage.tell_interrupted : nullptr);
  {
    const mpi::InterruptGuard guard({.last_words = [&] { last_line.tell(); }});
    const mpi::RunReport report =
        mpi::run_tasks(world, std::move(board), hooks,
                       [&](std::int64_t task, MPI_Comm) { return stage.work(task); });
    end.interrupted = report.interrupted;
  }
  progress.finish("");
  if (end.interrupted) last_line.tell();
  for (auto& [number, failure] : failures) end.failures.push_back(std::move(failure));
  end.seconds = core::monotonic_seconds() - start;
  const json shared = json::parse(mpi::broadcast(
      json{end.tasks_run, end.seconds, end.rank_seconds, end.failures}.dump(), 0, world));
  end.tasks_run = shared[0];
  end.seconds = shared[1];
  end.rank_seconds = shared[2];
  end.failures = shared[3].get<std::vector<json>>();
  return end;
}

}  // namespace carillon::eval::studies
