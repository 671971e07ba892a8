#include "scene/detail/turned_object.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"
#include "mpi/comm.hpp"
#include "solvers/axisymmetric/solve_axisymmetric.hpp"
#include "solvers/families/families.hpp"
#include "solvers/modes/modes_broadcast.hpp"

namespace carillon::scene {

namespace {

const solvers::families::Family& turned_family(const solvers::mesh::MeshRequest& request) {
  std::vector<std::string> names;
  for (const auto& family : solvers::families::families()) {
    // A profile cannot be given on the command line.
    if (family.meridian && !family.parameters.empty()) names.push_back(family.name);
  }
  const auto hint = fmt::format("bodies of revolution: {}", fmt::join(names, ", "));
  if (request.shape.family.empty()) {
    throw core::InputError("the axisymmetric solver needs a generated shape, not a file", hint);
  }
  const auto& family = solvers::families::find_family(request.shape.family);
  if (!family.meridian) {
    throw core::InputError(
        fmt::format("{} is not a body of revolution, which the axisymmetric solver needs",
                    family.name),
        hint);
  }
  return family;
}

}  // namespace

SolvedObject solve_turned(const ObjectRequest& request, MPI_Comm comm) {
  SolvedObject object;
  mpi::agreed(comm, [&] {
    const auto meridian = turned_family(request.mesh).meridian(request.mesh.shape);
    check_size(solvers::mesh::measure(meridian).longest_side(), request.any_size);
    object.mesh.mesh.region_names = {"body"};
    object.materials = assign_materials(request.materials, object.mesh.mesh.region_names);
    if (mpi::rank(comm) != 0) return;
    solvers::axisymmetric::AxisymmetricOptions axisymmetric;
    axisymmetric.cell = request.mesh.options.element_size;
    object.modes = solvers::axisymmetric::solve_axisymmetric(
        meridian, object.materials.front().elastic, request.solve, axisymmetric, object.trace);
  });
  solvers::modes::broadcast(object.modes, comm);
  return object;
}

}  // namespace carillon::scene
