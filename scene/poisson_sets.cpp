#include "scene/poisson_sets.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "scene/turned_sets.hpp"
#include "solvers/basis/solve_materials.hpp"

namespace carillon::scene {

namespace {

std::vector<solvers::basis::ModeRequest> requests_of(const ObjectRequest& request,
                                                     const SolvedObject& object,
                                                     std::span<const double> ratios) {
  if (object.materials.size() != 1) {
    throw core::InputError(fmt::format("the object has {} regions", object.materials.size()),
                           "one material is sought: give an object of one region");
  }
  std::vector<solvers::basis::ModeRequest> requests;
  for (const double ratio : ratios) {
    requests.push_back({elastic_of(object.materials), request.solve.band});
    requests.back().regions.front().poisson_ratio = ratio;
  }
  return requests;
}

}  // namespace

PoissonSets solve_poisson_ratios(const ObjectRequest& request, std::span<const double> ratios,
                                 MPI_Comm comm, const std::filesystem::path& cache) {
  ObjectRequest first = request;
  // Without a target this set only shows that the object can be solved.
  if (ratios.size() > 1 && request.pitch_cents == 0) first.solve.estimate_errors = false;
  SolvedObject object = solve_object(first, comm, cache);
  PoissonSets sets;
  sets.poisson_ratios.assign(ratios.begin(), ratios.end());
  sets.warnings = std::move(object.warnings);
  sets.trace = std::move(object.trace);
  const auto requests = requests_of(request, object, ratios);
  if (requests.size() == 1 && ratios.front() == object.materials.front().elastic.poisson_ratio) {
    sets.modes.push_back(std::move(object.modes));
  } else if (object.solver.solver == ObjectSolver::axisymmetric) {
    sets.modes =
        solve_turned(request.mesh.shape, requests,
                     {request.solve, request.pitch_cents, request.mesh.options.element_size}, comm,
                     cache, sets.trace)
            .sets;
  } else {
    sets.modes = solvers::basis::solve_materials(object.mesh.mesh, requests, request.solve, comm,
                                                 cache, sets.trace);
  }
  return sets;
}

}  // namespace carillon::scene
