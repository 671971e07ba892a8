// Modes of triangles in memory: a wedge of glass.
//   ./modes, or on more ranks: mpirun -n 2 ./modes
#include <carillon/mpi/comm.hpp>
#include <carillon/scene/solved_object.hpp>
#include <carillon/solvers/libraries/environment.hpp>
#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  const carillon::mpi::Environment mpi(argc, argv);
  const carillon::solvers::libraries::SolverEnvironment libraries;

  carillon::scene::ObjectRequest request;
  request.mesh.file.path = "wedge";  // its name in messages
  request.mesh.file.surface.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.06, 0}, {0, 0, 0.04}};  // [m]
  request.mesh.file.surface.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  request.materials[""] = carillon::synth::material::parse_material("glass");
  request.solve.band.max_frequency = 100e3;
  request.solve.band.max_modes = 5;
  const carillon::scene::SolvedObject object = carillon::scene::solve_object(request);

  if (carillon::mpi::rank(MPI_COMM_WORLD) == 0) {
    for (std::size_t i = 0; i < object.modes.size(); ++i) {
      std::printf("%10.2f Hz, within %.2g cents\n", object.modes.frequency(i),
                  object.modes.pitch_errors[i]);
    }
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "modes: %s\n", error.what());
  return 1;
}
