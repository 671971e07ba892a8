#include "cli/pitch.hpp"

#include "cli/body.hpp"
#include "mpi/comm.hpp"
#include "solvers/read_mesh.hpp"

namespace carillon::cli {

bool gives_tetrahedra(const solvers::MeshRequest& request) {
  return request.shape.family.empty() && solvers::mesh_extension(request.file.path) == ".msh";
}

solvers::PitchTarget pitch_target(const PitchSearch& search) {
  solvers::PitchTarget target;
  target.cents = search.cents;
  target.start = search.request.options;
  target.fixed_mesh = gives_tetrahedra(search.request);
  target.linear_solver = search.linear_solver;
  target.memory_limit = search.memory_limit;
  return target;
}

solvers::PitchResult refine_to_pitch(const PitchSearch& search, const SetSolver& solve,
                                     MPI_Comm comm, core::Trace& trace) {
  const auto make_mesh = [&](const solvers::MeshOptions& options) {
    solvers::MeshRequest request = search.request;
    request.options = options;
    const core::ScopedTimer timer(mesh_entry(trace, request, search.cache));
    return shared_mesh(request, search.limits, search.cache, comm);
  };
  auto result = solvers::reach_pitch(pitch_target(search), make_mesh, solve);
  for (auto& modes : result.sets) modes = solvers::without_margin(modes);
  return result;
}

}  // namespace carillon::cli
