#include "dataset/run/costs.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "dataset/plan/disk.hpp"
#include "dataset/run/expected_shapes.hpp"
#include "solvers/pitch/expected_costs.hpp"

namespace carillon::dataset::run {

namespace {

mpi::Task modes_task(const configuration::BuildConfig& config, const ExpectedShape& shape) {
  mpi::Task task;
  task.cost = modes_seconds(shape) + config.scene.seconds_per_shape();
  if (shape.about_axis) {
    task.width = 1;
    task.memory = 3e7;
    task.kind = "modes about an axis";
    return task;
  }
  const auto sets = static_cast<double>(shape.modes.size());
  task.width = configuration::group_width(config.ranks, shape.last.unknowns());
  task.memory = solvers::pitch::solve_memory(shape.last, {1, shape.max_modes(), sets}, task.width,
                                             static_cast<double>(config.solver.memory_limit));
  task.kind = task.width > 1 ? "modes of groups" : "modes";
  return task;
}

/// @param modes  of a sound
mpi::Task samples_task(const configuration::BuildConfig& config, const plan::BuildTask& entry,
                       double modes) {
  mpi::Task task;
  const double rows = static_cast<double>(config.scene.rows());
  const auto count = static_cast<double>(entry.count);
  const double values = count * rows * static_cast<double>(config.scene.audio.samples());
  // Reading the modes, and writing and syncing what was made.
  task.cost =
      0.025 + 3e-8 * values + count * config.scene.seconds_per_sound(static_cast<int>(modes));
  // Columns of simulations hold far more than their sound.
  const double columns = config.motion ? count * plan::sample_bytes(config).total() : values * 4;
  task.memory = columns + 6e7;
  for (const scene::EffectDecision& effect : config.scene.effects) {
    if (effect.enabled) task.memory += effect.in_scene.memory;
  }
  // Modes tasks come first, by shape.
  for (const std::size_t s : entry.needs()) task.after.push_back(static_cast<std::int64_t>(s));
  task.kind = "samples";
  return task;
}

}  // namespace

std::vector<mpi::Task> board_tasks(const plan::BuildPlan& plan,
                                   const configuration::BuildConfig& config) {
  const std::vector<ExpectedShape> shapes = expected_shapes(config, plan);
  std::vector<mpi::Task> tasks;
  for (const plan::BuildTask& entry : plan.tasks) {
    const ExpectedShape& shape = shapes[entry.shape];
    tasks.push_back(entry.kind == plan::TaskKind::samples
                        ? samples_task(config, entry, shape.mean_modes())
                        : modes_task(config, shape));
    tasks.back().key = entry.key;
  }
  return tasks;
}

}  // namespace carillon::dataset::run
