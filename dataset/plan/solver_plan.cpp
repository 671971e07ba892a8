#include "dataset/plan/solver_plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string>

#include "core/progress.hpp"

namespace carillon::dataset::plan {

namespace {

using nlohmann::json;

const char* linear_solver_reason(solvers::modes::LinearSolver solver) {
  switch (solver) {
    case solvers::modes::LinearSolver::direct:
      return "Cholesky, modes counted by inertia; an object beyond the memory limit fails";
    case solvers::modes::LinearSolver::iterative:
      return "multigrid; modes are found but not counted";
    case solvers::modes::LinearSolver::automatic:
      break;
  }
  return "direct (Cholesky, modes counted) while its factor fits the memory limit, else iterative";
}

/// Shapes of a solver, by the reason that it is theirs.
SolverChoice shapes_of(scene::ObjectSolver solver, const BuildPlan& plan) {
  std::map<std::string, std::size_t> reasons;
  std::size_t count = 0;
  for (const Shape& shape : plan.shapes) {
    if (shape.solver.solver != solver) continue;
    ++count;
    ++reasons[shape.solver.reason];
  }
  std::vector<std::string> texts;
  for (const auto& [reason, shapes] : reasons)
    texts.push_back(fmt::format("{}: {}", shapes, reason));
  return {std::string(scene::name_of(solver)), count,
          fmt::format("{} shape{}", count, count == 1 ? "" : "s"),
          fmt::format("{}", fmt::join(texts, "; "))};
}

void add_tetrahedral(const configuration::BuildConfig& config, std::vector<SolverChoice>& list) {
  const bool refined = config.pitch_cents > 0;
  const double size = config.mesh.element_size;
  list.push_back({"order", config.mesh.order, fmt::format("{}", config.mesh.order),
                  refined ? "the first setting; the pitch target chooses from 2 to 4"
                          : "of the elements, the same for every object"});
  list.push_back({"element_size", size > 0 ? json(size) : json(),
                  size > 0 ? fmt::format("{:.4g} m", size) : "automatic",
                  std::string(size > 0 ? "largest edge"
                                       : "from each object's thickness and "
                                         "curvature") +
                      (refined ? "; the first setting" : "")});
  list.push_back({"max_elements", config.mesh.max_elements,
                  fmt::format("{}", config.mesh.max_elements),
                  "an object that needs more fails, with the size that would fit"});
  list.push_back({"edge_layers", config.mesh.edge_layers,
                  fmt::format("{}", config.mesh.edge_layers),
                  std::string("of thin elements at inward edges, where an object has them") +
                      (refined ? "; more for pitch targets below 4 cents" : "")});
  if (refined)
    list.push_back({"max_unknowns", config.max_unknowns, fmt::format("{}", config.max_unknowns),
                    "a refinement that takes more is left out"});
  const std::string eigen_solver(solvers::modes::name_of(config.solver.solver));
  list.push_back(
      {"eigen_solver", eigen_solver, eigen_solver,
       "dense instead for a few hundred unknowns; LOBPCG in place of block Lanczos where "
       "linear solves are iterative"});
  const std::string linear_solver(solvers::modes::name_of(config.solver.linear_solver));
  list.push_back({"linear_solver", linear_solver, linear_solver,
                  linear_solver_reason(config.solver.linear_solver)});
  const bool mirrored = config.solver.mirror_planes;
  list.push_back({"mirror_planes", mirrored ? "automatic" : "off", mirrored ? "automatic" : "off",
                  mirrored
                      ? "objects whose tetrahedra are exactly symmetric are solved as the part "
                        "beside the planes, once for each class of modes"
                      : "every object is solved whole"});
  list.push_back({"memory_limit", config.solver.memory_limit,
                  core::human_binary_bytes(static_cast<double>(config.solver.memory_limit)),
                  "of each modes task, all ranks of its group together"});
}

}  // namespace

std::vector<SolverChoice> plan_solver(const configuration::BuildConfig& config,
                                      const BuildPlan& plan) {
  const bool refined = config.pitch_cents > 0;
  const solvers::modes::Band& band = config.band;
  std::vector<SolverChoice> list = {shapes_of(scene::ObjectSolver::axisymmetric, plan),
                                    shapes_of(scene::ObjectSolver::tetrahedra, plan)};
  const bool has_tetrahedra = list.back().value != 0;
  const auto tuned = std::count_if(plan.shapes.begin(), plan.shapes.end(), [](const Shape& shape) {
    return shape.variants.front().tune > 0;
  });
  if (tuned > 0) {
    list.push_back({"tuned", tuned, fmt::format("{} shape{}", tuned, tuned == 1 ? "" : "s"),
                    "every length is scaled to the pitch of objects[].tune in each material, once "
                    "the modes are known; estimates guess the size"});
  }
  list.push_back({"pitch_target", refined ? json(config.pitch_cents) : json(),
                  refined ? fmt::format("{:.4g} cents", config.pitch_cents) : "none",
                  refined ? "each object is refined until its worst mode's estimate is below it"
                          : "solver.pitch_cents is off: errors are estimated, meshes are kept"});
  list.push_back({"band", json{band.min_frequency, band.max_frequency},
                  fmt::format("{:.6g} to {:.6g} Hz", band.min_frequency, band.max_frequency),
                  "wider in a solve that serves several materials or sizes"});
  list.push_back({"max_modes", band.max_modes, fmt::format("{}", band.max_modes),
                  "the lowest so many in the band of each material and size"});
  if (has_tetrahedra) add_tetrahedral(config, list);
  return list;
}

}  // namespace carillon::dataset::plan
