#include "dataset/run/costs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "dataset/plan/disk.hpp"
#include "dataset/plan/expected_mesh.hpp"
#include "dataset/samples/modes_task.hpp"
#include "solvers/basis/solve_materials.hpp"

namespace carillon::dataset::run {

namespace {

/// What the mode sets of a shape come to.
struct ExpectedSets {
  double solves = 1;  ///< eigensolves: of each set, or of a basis for many
  double modes = 10;  ///< of the largest set
  double sets = 1;
};

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
    const double below = solvers::basis::expected_modes(
        object.volume, object.thickness, request.regions[0], request.band.max_frequency);
    const double most = std::min<double>(request.band.max_modes, unknowns / 4);
    out.modes = std::max(out.modes, std::min(below, most));
  }
  return out;
}

/// Seconds of one rank of a 2.3 GHz Xeon, within a factor of two for objects of 600 to 400,000
/// unknowns: the mesher's process, and solves with their counts and error estimates.
double modes_seconds(const solvers::pitch::MeshSize& mesh, const ExpectedSets& sets) {
  const double solve = 5e-6 * std::pow(mesh.unknowns(), 1.3) * std::pow(mesh.layers(), 0.35) *
                       (sets.modes + 40) / 56;
  // Sets from a basis cost a tenth of a solve.
  return 0.12 + 2e-5 * mesh.elements + (sets.solves + 0.1 * (sets.sets - sets.solves)) * solve;
}

/// [byte] of K and M.
double matrix_bytes(const solvers::pitch::MeshSize& mesh) {
  return 12 * 3 * mesh.unknowns() * (20 + 25 * mesh.order);
}

/// [byte] of judging the modes by elements of the next order: its element matrices, fields of as
/// many modes as are judged at a time, and local solves, or, where elements are wide against a thin
/// wall, a factor of that order (solvers/finer_factor.hpp). Every rank of a group has whole fields.
double judging_bytes(const solvers::pitch::MeshSize& mesh, double modes, int ranks) {
  constexpr double wide = 3.5, max_at_once = 128, fields_each = 9;
  const solvers::pitch::MeshSize finer = solvers::pitch::resized(mesh, mesh.order + 1, 1);
  const double nodes = (finer.order + 1) * (finer.order + 2) * (finer.order + 3) / 6.0;
  const double kept = 80 * nodes * nodes * mesh.elements;
  const double fields = ranks * fields_each * 8 * finer.unknowns() * std::min(modes, max_at_once);
  const double local = 4 * 9 * nodes * nodes * mesh.elements;
  const bool factored = mesh.element_size > wide * mesh.thickness;
  return 1.15 * (kept + fields) +
         (factored ? 1.3 * solvers::pitch::factor_memory(finer) + matrix_bytes(finer) : local);
}

/// [byte] at the peak of a modes task on all its ranks, within a quarter of what most objects of
/// 600 to 100,000 unknowns were seen to hold beside idle ranks: matrices, and either a direct
/// solve's factor and vectors or the judging of its modes; what does not fit the memory limit is
/// solved by other means within it.
double modes_memory(const configuration::BuildConfig& config, const solvers::pitch::MeshSize& mesh,
                    const ExpectedSets& sets, int ranks) {
  constexpr double libraries = 6e7;  // that the first task wakes
  const double n = mesh.unknowns();
  const double solving = 1.3 * solvers::pitch::factor_memory(mesh) + 8 * n * (5 * sets.modes + 80);
  const double others = 12 * n * sets.modes * (sets.sets - 1);
  const double all =
      matrix_bytes(mesh) + std::max(solving, judging_bytes(mesh, sets.modes, ranks)) + others;
  return ranks * libraries + std::min(all, static_cast<double>(config.solver.memory_limit));
}

mpi::Task modes_task(const configuration::BuildConfig& config, const plan::ExpectedObject& object,
                     const ExpectedSets& sets) {
  mpi::Task task;
  task.cost = modes_seconds(object.mesh, sets);
  // A pitch target takes a first solve, and as a rule a larger second one.
  if (config.pitch_cents > 0) task.cost *= 3;
  task.cost += config.scene.seconds_per_shape();
  task.width = configuration::group_width(config.ranks, object.mesh.unknowns());
  task.memory = modes_memory(config, object.mesh, sets, task.width);
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
    tasks.push_back(entry.kind == plan::TaskKind::modes
                        ? modes_task(config, objects[s], sets[s])
                        : samples_task(config, entry, sets[s].modes));
    tasks.back().key = entry.key;
  }
  return tasks;
}

}  // namespace carillon::dataset::run
