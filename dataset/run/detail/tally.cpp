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

}  // namespace

Tally::Tally(const std::vector<BuildRun>& builds) : runs_(builds) {
  for (const BuildRun& run : builds) {
    const plan::BuildPlan& plan = run.build.plan;
    Build build{std::vector<Object>(plan.shapes.size()), std::vector<bool>(plan.tasks.size())};
    for (std::size_t t = 0; t < plan.tasks.size(); ++t) {
      const plan::BuildTask& task = plan.tasks[t];
      ++tasks_.all;
      if (is_of_object(task)) ++build.objects[task.shape].open;
      if (task.kind != plan::TaskKind::samples) continue;
      samples_.all += static_cast<std::int64_t>(task.count);
      for (const std::size_t shape : task.needs()) build.objects[shape].samples.push_back(t);
    }
    for (const Object& object : build.objects) objects_.all += object.open > 0 ? 1 : 0;
    builds_.push_back(std::move(build));
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

void Tally::settle_samples(std::size_t build, std::size_t task, bool ok) {
  if (builds_[build].settled[task]) return;
  builds_[build].settled[task] = true;
  (ok ? samples_.done : samples_.failed) +=
      static_cast<std::int64_t>(runs_[build].build.plan.tasks[task].count);
}

void Tally::count(std::size_t build, const plan::BuildTask& task, const json& entry) {
  const bool ok = entry.value("ok", false);
  ++(ok ? tasks_.done : tasks_.failed);
  if (ok) {
    for (const json& file : entry.value("files", json::array()))
      bytes_ += file.get<ListedFile>().bytes;
  }
  if (task.kind == plan::TaskKind::samples) {
    const std::vector<plan::BuildTask>& tasks = runs_[build].build.plan.tasks;
    settle_samples(build, static_cast<std::size_t>(&task - tasks.data()), ok);
  } else if (!ok) {
    for (const std::size_t lost : builds_[build].objects[task.shape].samples)
      settle_samples(build, lost, false);
  }
  if (!is_of_object(task)) return;
  Object& object = builds_[build].objects[task.shape];
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

std::optional<double> Tally::rate(double elapsed_s) const {
  const std::int64_t made = samples_.done - samples_before_;
  if (made == 0 || !(elapsed_s > 0)) return std::nullopt;
  return static_cast<double>(made) / elapsed_s;
}

std::string Tally::text(double elapsed_s) const {
  std::string text = fmt::format("{} of {} samples", samples_.done, samples_.all);
  if (const auto fast = rate(elapsed_s)) text += fmt::format("  {:.3g} samples/s", *fast);
  text += fmt::format("  {} of {} objects", objects_.done, objects_.all);
  if (tasks_.failed > 0)
    text += fmt::format("  {} task{} failed", tasks_.failed, tasks_.failed == 1 ? "" : "s");
  return text + "  " + core::human_bytes(static_cast<double>(bytes_));
}

}  // namespace carillon::dataset::run
