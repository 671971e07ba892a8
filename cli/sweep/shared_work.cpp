#include "cli/sweep/shared_work.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "cli/build/costs.hpp"
#include "core/hash.hpp"
#include "solvers/mesh_child.hpp"

namespace carillon::cli {

namespace {

constexpr double cached_modes_seconds = 0.1;

void add_elastic(core::Sha256& hash, const synth::Material& material) {
  hash.add(fmt::format("{} {} {};", material.elastic.youngs_modulus, material.elastic.poisson_ratio,
                       material.elastic.density));
}

/// Everything beside the mesh that a shape's mode sets depend on.
std::string solve_key(const BuildConfig& config, const Shape& shape, const std::string& mesh) {
  core::Sha256 hash;
  const solvers::SolveOptions& solver = config.solver;
  // Limits change no value, but who fails by them.
  const TaskLimits& limits = config.limits;
  hash.add(fmt::format("{} {} {} {};", limits.mesh.seconds, limits.mesh.memory, limits.solve_time,
                       limits.solve_memory));
  hash.add(fmt::format("{} {} {} {} {} {} {} {} {};", mesh, config.pitch_cents,
                       config.band.min_frequency, config.band.max_frequency, config.band.max_modes,
                       static_cast<int>(solver.solver), static_cast<int>(solver.linear_solver),
                       solver.memory_limit, solver.tolerance));
  for (const auto& [group, name] : config.objects[shape.source].groups) {
    hash.add(group + "=");
    add_elastic(hash, synth::parse_material(name, config.own_materials));
  }
  for (const Variant& variant : shape.variants) {
    hash.add(fmt::format("{}:", variant.size));
    if (config.objects[shape.source].groups.empty()) {
      add_elastic(hash, synth::parse_material(variant.material, config.own_materials));
    }
  }
  return hash.hex();
}

}  // namespace

SharedKeys SharedWork::keys(const BuildConfig& config, const Shape& shape) {
  std::string& mesh = mesh_keys_[solvers::to_json(shape.request).dump()];
  if (mesh.empty()) mesh = solvers::mesh_key(shape.request);
  return {mesh, solve_key(config, shape, mesh)};
}

SameWork order_shared_work(const std::vector<BuildRun>& builds, std::vector<mpi::Task>& tasks,
                           const std::vector<std::size_t>& first) {
  SharedWork work;
  std::vector<std::pair<std::size_t, SharedKeys>> modes_tasks;
  for (std::size_t b = 0; b < builds.size(); ++b) {
    const LoadedBuild& build = builds[b].build;
    for (std::size_t t = 0; t < build.plan.tasks.size(); ++t) {
      const BuildTask& task = build.plan.tasks[t];
      if (task.kind != TaskKind::modes) continue;
      modes_tasks.emplace_back(first[b] + t,
                               work.keys(build.config, build.plan.shapes[task.shape]));
    }
  }
  // A task may only wait for one of its own width or wider.
  std::stable_sort(modes_tasks.begin(), modes_tasks.end(), [&](const auto& a, const auto& b) {
    return tasks[a.first].width > tasks[b.first].width;
  });
  SameWork same;
  std::map<std::string, std::size_t> meshed, solved;
  for (const auto& [number, keys] : modes_tasks) {
    const std::size_t mesh = meshed.emplace(keys.mesh, number).first->second;
    const std::size_t solve = solved.emplace(keys.modes, number).first->second;
    for (const std::size_t leader : std::set<std::size_t>{mesh, solve}) {
      if (leader != number) tasks[number].behind.push_back(static_cast<std::int64_t>(leader));
    }
    if (solve == number) continue;
    same[static_cast<std::int64_t>(solve)].push_back(static_cast<std::int64_t>(number));
    tasks[number].cost = std::min(tasks[number].cost, cached_modes_seconds);
    tasks[number].kind = "modes from cache";
  }
  return same;
}

SharingCounts count_shared_work(const std::vector<LoadedBuild>& builds) {
  SharedWork work;
  SharingCounts counts;
  std::set<std::string> meshes, solves;
  for (const LoadedBuild& build : builds) {
    const std::vector<mpi::Task> tasks = board_tasks(build.plan, build.config);
    for (std::size_t t = 0; t < tasks.size(); ++t) {
      const BuildTask& task = build.plan.tasks[t];
      if (task.kind != TaskKind::modes) continue;
      const SharedKeys keys = work.keys(build.config, build.plan.shapes[task.shape]);
      ++counts.bodies;
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

}  // namespace carillon::cli
