#include "scene/pitch.hpp"

#include "mpi/comm.hpp"
#include "scene/solved_object.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"

namespace carillon::scene {

bool gives_tetrahedra(const solvers::mesh::MeshRequest& request) {
  return request.shape.family.empty() && solvers::mesh::readers::gives_tetrahedra(request.file);
}

solvers::pitch::PitchTarget pitch_target(const PitchSearch& search) {
  solvers::pitch::PitchTarget target;
  target.cents = search.cents;
  target.start = search.request.options;
  target.fixed_mesh = gives_tetrahedra(search.request);
  target.linear_solver = search.linear_solver;
  target.memory_limit = search.memory_limit;
  target.max_unknowns = search.max_unknowns;
  return target;
}

solvers::pitch::PitchResult refine_to_pitch(const PitchSearch& search, const SetSolver& solve,
                                            MPI_Comm comm, core::Trace& trace,
                                            const SetSolver& probe) {
  const auto make_mesh = [&](const solvers::mesh::MeshOptions& options) {
    solvers::mesh::MeshRequest request = search.request;
    request.options = options;
    const core::ScopedTimer timer(mesh_entry(trace, request, search.cache));
    return shared_mesh(request, search.limits, search.cache, comm);
  };
  auto result = solvers::pitch::reach_pitch(pitch_target(search), make_mesh, solve, probe);
  for (auto& modes : result.sets) modes = solvers::pitch::without_margin(modes);
  return result;
}

}  // namespace carillon::scene
