#include "scene/object_solver.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/error.hpp"
#include "solvers/families/families.hpp"

namespace carillon::scene {
namespace {

constexpr std::array solvers_by_name = {ObjectSolver::automatic, ObjectSolver::tetrahedra,
                                        ObjectSolver::axisymmetric};

/// Why an object cannot be solved about an axis; "" where it can.
std::string obstacle(const solvers::mesh::MeshRequest& request,
                     std::span<const solvers::elements::Elastic> materials) {
  if (request.shape.family.empty()) return "a file tells no axis";
  if (!solvers::families::find_family(request.shape.family).meridian)
    return fmt::format("{} is no body of revolution", request.shape.family);
  if (std::any_of(materials.begin(), materials.end(),
                  [](const solvers::elements::Elastic& m) { return m.anisotropy.has_value(); }))
    return "its material is anisotropic";
  return "";
}

std::string bodies_of_revolution() {
  std::vector<std::string> names;
  for (const solvers::families::Family& family : solvers::families::families())
    if (family.meridian) names.push_back(family.name);
  return fmt::format("bodies of revolution: {}", fmt::join(names, ", "));
}

}  // namespace

std::string_view name_of(ObjectSolver solver) {
  switch (solver) {
    case ObjectSolver::tetrahedra:
      return "tetrahedra";
    case ObjectSolver::axisymmetric:
      return "axisymmetric";
    case ObjectSolver::automatic:
      break;
  }
  return "automatic";
}

ObjectSolver parse_object_solver(std::string_view name) {
  for (const ObjectSolver solver : solvers_by_name)
    if (name_of(solver) == name) return solver;
  throw core::InputError(fmt::format("there is no solver \"{}\"", name),
                         "automatic, tetrahedra or axisymmetric");
}

SolverDecision decide_solver(const SolverRequest& asked, const solvers::mesh::MeshRequest& request,
                             std::span<const solvers::elements::Elastic> materials) {
  if (asked.solver == ObjectSolver::tetrahedra) return {ObjectSolver::tetrahedra, asked.reason};
  const std::string why_not = obstacle(request, materials);
  if (asked.solver == ObjectSolver::axisymmetric) {
    if (why_not.empty()) return {ObjectSolver::axisymmetric, asked.reason};
    throw core::InputError(
        fmt::format("the axisymmetric solver cannot take this object: {}", why_not),
        bodies_of_revolution());
  }
  if (!why_not.empty()) return {ObjectSolver::tetrahedra, why_not};
  return {ObjectSolver::axisymmetric,
          fmt::format("{} is a body of revolution", request.shape.family)};
}

}  // namespace carillon::scene
