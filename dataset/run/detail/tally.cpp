#include "dataset/run/detail/tally.hpp"

#include <fmt/format.h>

#include "core/progress.hpp"
#include "dataset/run/check_files.hpp"
#include "dataset/run/detail/run_state.hpp"

namespace carillon::dataset::run {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

/// Simulations are no one object's.
bool is_of_object(const plan::BuildTask& task) {
  return task.kind == plan::TaskKind::modes || task.cast.empty();
}

std::int64_t samples_of(const plan::BuildTask& task) {
  return task.kind == plan::TaskKind::samples ? static_cast<std::int64_t>(task.count) : 0;
}

}  // namespace

Tally::Tally(const std::vector<BuildRun>& builds) {
  for (const BuildRun& run : builds) {
    std::vector<Object>& objects = by_build_.emplace_back(run.build.plan.shapes.size());
    for (const plan::BuildTask& task : run.build.plan.tasks) {
      ++tasks_.all;
      samples_.all += samples_of(task);
      if (is_of_object(task)) ++objects[task.shape].open;
    }
    for (const Object& object : objects) objects_.all += object.open > 0 ? 1 : 0;
  }
}

void Tally::take_over(RunState& state, const mpi::TaskBoard& board) {
  for (std::size_t i = 0; i < board.tasks().size(); ++i) {
    const auto number = static_cast<std::int64_t>(i);
    const mpi::TaskState now = board.state(number);
    if (now != mpi::TaskState::done && now != mpi::TaskState::failed) continue;
    const RunState::Place place = state.place_of(number);
    const auto& finished = state.finished(place.build);
    const auto entry = finished.find(place.task.key);
    count(place.build, place.task,
          entry == finished.end() ? json{{"ok", now == mpi::TaskState::done}} : entry->second);
  }
  samples_before_ = samples_.done;
}

void Tally::count(std::size_t build, const plan::BuildTask& task, const json& entry) {
  const bool ok = entry.value("ok", false);
  ++(ok ? tasks_.done : tasks_.failed);
  (ok ? samples_.done : samples_.failed) += samples_of(task);
  if (ok) {
    for (const json& file : entry.value("files", json::array()))
      bytes_ += file.get<ListedFile>().bytes;
  }
  if (!is_of_object(task)) return;
  Object& object = by_build_[build][task.shape];
  --object.open;
  if (!ok && !object.failed) ++objects_.failed;
  object.failed = object.failed || !ok;
  if (object.open == 0 && !object.failed) ++objects_.done;
}

ordered_json Tally::to_json(const Count& count) {
  return {{"all", count.all}, {"done", count.done}, {"failed", count.failed}};
}

ordered_json Tally::to_json() const {
  return {{"samples", to_json(samples_)},
          {"objects", to_json(objects_)},
          {"tasks", to_json(tasks_)},
          {"bytes", bytes_}};
}

std::string Tally::text() const {
  std::string text = fmt::format("{} of {} samples  {} of {} objects", samples_.done, samples_.all,
                                 objects_.done, objects_.all);
  if (tasks_.failed > 0)
    text += fmt::format("  {} task{} failed", tasks_.failed, tasks_.failed == 1 ? "" : "s");
  return text + "  " + core::human_bytes(static_cast<double>(bytes_));
}

}  // namespace carillon::dataset::run
