#include "dataset/sweep/detail/shared_work.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/hash.hpp"
#include "dataset/run/costs.hpp"
#include "scene/object.hpp"
#include "solvers/mesher/mesh_child.hpp"

namespace carillon::dataset::sweep {

namespace {

constexpr double cached_modes_seconds = 0.1;
/// A mesh and modes at its surface against what solving holds: the factor above all.
constexpr double cached_memory_fraction = 0.2;

void add_elastic(core::Sha256& hash, const synth::material::Material& material) {
  hash.add(fmt::format("{};", fmt::join(solvers::elements::identity_of(material.elastic), " ")));
}

/// Everything beside the mesh that a shape's mode sets depend on.
std::string solve_key(const configuration::BuildConfig& config, const plan::Shape& shape,
                      const std::string& mesh) {
  core::Sha256 hash;
  const solvers::eigen::SolveOptions& solver = config.solver;
  // Limits change no value, but who fails by them.
  const configuration::TaskLimits& limits = config.limits;
  hash.add(fmt::format("{} {} {} {};", limits.mesh.seconds, limits.mesh.memory, limits.solve_time,
                       limits.solve_memory));
  hash.add(fmt::format("{} {} {} {} {} {} {} {} {} {} {};", mesh, config.pitch_cents,
                       config.pitch_cents > 0 ? config.max_unknowns : 0, config.band.min_frequency,
                       config.band.max_frequency, config.band.max_modes,
                       static_cast<int>(solver.solver), static_cast<int>(solver.linear_solver),
                       solver.memory_limit, solver.tolerance, solver.mirror_planes));
  const scene::Object& object = config.objects[shape.source].object;
  for (const auto& [group, name] : object.groups) {
    hash.add(group + "=");
    add_elastic(hash, scene::object_material(object, name, config.own_materials));
  }
  for (const plan::Variant& variant : shape.variants) {
    hash.add(fmt::format("{}:", plan::size_name(variant)));
    if (object.groups.empty()) {
      add_elastic(hash, scene::object_material(object, variant.material, config.own_materials));
    }
  }
  return hash.hex();
}

}  // namespace

SharedKeys SharedWork::keys(const configuration::BuildConfig& config, const plan::Shape& shape) {
  std::string& mesh = mesh_keys_[solvers::mesh::to_json(shape.request).dump()];
  if (mesh.empty()) {
    const bool is_there = shape.path.empty() || !shape.sha256.empty();
    mesh = is_there ? solvers::mesher::mesh_key(shape.request) : "missing " + shape.path;
  }
  const solvers::mesher::ChildLimits& limits = config.limits.mesh;
  return {mesh, solve_key(config, shape, mesh),
          fmt::format(" within {} {}", limits.seconds, limits.memory)};
}

namespace {

struct ModesTask {
  std::size_t number;
  SharedKeys keys;
};

/// Modes tasks that are not done, the widest first: a task may only wait for one of its own width
/// or wider.
std::vector<ModesTask> open_modes_tasks(const std::vector<run::BuildRun>& builds,
                                        const run::CommonTasks& common) {
  SharedWork work;
  std::vector<ModesTask> open;
  for (std::size_t b = 0; b < builds.size(); ++b) {
    const run::LoadedBuild& build = builds[b].build;
    for (std::size_t t = 0; t < build.plan.tasks.size(); ++t) {
      const plan::BuildTask& task = build.plan.tasks[t];
      const std::size_t number = common.first[b] + t;
      if (task.kind != plan::TaskKind::modes || common.done[number]) continue;
      open.push_back({number, work.keys(build.config, build.plan.shapes[task.shape])});
    }
  }
  std::stable_sort(open.begin(), open.end(), [&](const auto& a, const auto& b) {
    return common.tasks[a.number].width > common.tasks[b.number].width;
  });
  return open;
}

}  // namespace

run::SameWork order_shared_work(const std::vector<run::BuildRun>& builds,
                                run::CommonTasks& common) {
  run::SameWork same;
  std::map<std::string, std::size_t> first;  // task by what it does
  for (const auto& open : open_modes_tasks(builds, common)) {
    const std::size_t number = open.number;
    const auto& keys = open.keys;
    const std::size_t mesh = first.emplace(keys.mesh, number).first->second;
    const std::size_t limited = first.emplace(keys.mesh + keys.mesh_limits, number).first->second;
    const std::size_t solve = first.emplace(keys.modes, number).first->second;
    mpi::Task& task = common.tasks[number];
    for (const std::size_t leader : std::set<std::size_t>{mesh, limited, solve}) {
      if (leader != number) task.behind.push_back(static_cast<std::int64_t>(leader));
    }
    const auto fails_with = [&](std::size_t leader, const char* stage) {
      if (leader == number) return;
      const auto key = std::pair(static_cast<std::int64_t>(leader), std::string(stage));
      same[key].push_back(static_cast<std::int64_t>(number));
    };
    fails_with(limited, "mesh");
    fails_with(solve, "solve");
    if (solve == number) continue;
    task.cost = std::min(task.cost, cached_modes_seconds);
    task.memory *= cached_memory_fraction;
    task.kind = "modes from cache";
  }
  return same;
}

SharingCounts count_shared_work(const std::vector<run::LoadedBuild>& builds) {
  SharedWork work;
  SharingCounts counts;
  std::set<std::string> meshes, solves;
  for (const run::LoadedBuild& build : builds) {
    const std::vector<mpi::Task> tasks = run::board_tasks(build.plan, build.config);
    for (std::size_t t = 0; t < tasks.size(); ++t) {
      const plan::BuildTask& task = build.plan.tasks[t];
      if (task.kind != plan::TaskKind::modes) continue;
      const SharedKeys keys = work.keys(build.config, build.plan.shapes[task.shape]);
      ++counts.objects;
      meshes.insert(keys.mesh);
      if (!solves.insert(keys.modes).second) {
        counts.seconds_saved += std::max(0.0, tasks[t].cost - cached_modes_seconds);
      }
    }
  }
  counts.meshes = meshes.size();
  counts.solves = solves.size();
  return counts;
}

}  // namespace carillon::dataset::sweep
