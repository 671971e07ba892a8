#include "dataset/run/costs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "dataset/plan/disk.hpp"
#include "dataset/plan/expected_mesh.hpp"
#include "dataset/samples/modes_task.hpp"
#include "solvers/basis/solve_materials.hpp"
#include "solvers/pitch/expected_costs.hpp"

namespace carillon::dataset::run {

namespace {

using solvers::pitch::ExpectedSets;

ExpectedSets expected_sets(const configuration::BuildConfig& config, const plan::Shape& shape,
                           const plan::ExpectedObject& object) {
  // Physical groups of a file are not known before it is read: one region stands for them.
  const configuration::ObjectSource& source = config.objects[shape.source];
  std::vector<std::vector<synth::material::Material>> materials;
  for (const plan::Variant& variant : shape.variants) {
    const std::string name =
        source.object.groups.empty() ? variant.material : source.object.groups.begin()->second;
    materials.push_back({synth::material::parse_material(name, config.own_materials)});
  }
  const samples::ModeSets sets = samples::group_variants(materials, shape.variants, config.band);
  ExpectedSets out;
  out.sets = static_cast<double>(sets.requests.size());
  // Up to three are solved one by one, more from a basis of three (solve_materials.hpp).
  out.solves = std::min(out.sets, 4.0);
  const double unknowns = object.mesh.unknowns();
  for (const solvers::basis::ModeRequest& request : sets.requests) {
    const double below =
        solvers::basis::expected_modes(object.extent.volume, object.extent.thickness,
                                       request.regions[0], request.band.max_frequency);
    const double largest = std::min<double>(request.band.max_modes, unknowns / 4);
    out.modes = std::max(out.modes, std::min(below, largest));
  }
  return out;
}

/// Of a section's harmonics on one rank of a 2.3 GHz Xeon, within a factor of two: each set is
/// solved on its own.
mpi::Task axisymmetric_task(const configuration::BuildConfig& config, const ExpectedSets& sets) {
  constexpr double seconds_per_set = 0.03, seconds_per_mode = 0.004, memory = 3e7;
  mpi::Task task;
  task.cost = sets.sets * (seconds_per_set + seconds_per_mode * sets.modes) +
              config.scene.seconds_per_shape();
  task.width = 1;
  task.memory = memory;
  task.kind = "modes about an axis";
  return task;
}

mpi::Task modes_task(const configuration::BuildConfig& config, plan::ExpectedObject object,
                     const ExpectedSets& sets) {
  mpi::Task task;
  if (!config.solver.mirror_planes) object.mesh.images = 1;
  task.cost = solvers::pitch::solve_seconds(object.mesh, sets);
  const solvers::pitch::MeshSize last =
      solvers::pitch::expected_refinement(object.mesh, config.pitch_cents, config.max_unknowns);
  if (last.unknowns() > object.mesh.unknowns())
    task.cost += solvers::pitch::solve_seconds(last, sets);
  task.cost += config.scene.seconds_per_shape();
  task.width = configuration::group_width(config.ranks, last.unknowns());
  task.memory = solvers::pitch::solve_memory(last, sets, task.width,
                                             static_cast<double>(config.solver.memory_limit));
  task.kind = task.width > 1 ? "modes of groups" : "modes";
  return task;
}

mpi::Task samples_task(const configuration::BuildConfig& config, const plan::BuildTask& entry,
                       double modes) {
  mpi::Task task;
  const double rows = static_cast<double>(config.scene.rows());
  const auto count = static_cast<double>(entry.count);
  const double values = count * rows * static_cast<double>(config.scene.audio.samples());
  // Reading the modes, and writing and syncing what was made.
  task.cost =
      0.02 + 1e-8 * values + count * config.scene.seconds_per_sound(static_cast<int>(modes));
  // Columns of simulations hold far more than their sound.
  const double columns = config.motion ? count * plan::sample_bytes(config) : values * 4;
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
  std::vector<plan::ExpectedObject> objects;
  std::vector<ExpectedSets> sets;
  for (const plan::Shape& shape : plan.shapes) {
    objects.push_back(plan::expected_object(shape));
    sets.push_back(expected_sets(config, shape, objects.back()));
  }
  std::vector<mpi::Task> tasks;
  for (const plan::BuildTask& entry : plan.tasks) {
    const std::size_t s = entry.shape;
    const bool about_axis = plan.shapes[s].solver.solver == scene::ObjectSolver::axisymmetric;
    tasks.push_back(entry.kind == plan::TaskKind::samples
                        ? samples_task(config, entry, sets[s].modes)
                    : about_axis ? axisymmetric_task(config, sets[s])
                                 : modes_task(config, objects[s], sets[s]));
    tasks.back().key = entry.key;
  }
  return tasks;
}

}  // namespace carillon::dataset::run
