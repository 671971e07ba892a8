#include "solvers/modes/modes_broadcast.hpp"

#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

#include "mpi/comm.hpp"

namespace carillon::solvers::modes {
namespace {

template <class T>
void plain(T& value, MPI_Comm comm, int root) {
  static_assert(std::is_trivially_copyable_v<T>);
  mpi::broadcast(&value, sizeof(T), root, comm);
}

template <class T>
void list(std::vector<T>& values, MPI_Comm comm, int root) {
  std::size_t count = values.size();
  plain(count, comm, root);
  values.resize(count);
  mpi::broadcast(values.data(), count * sizeof(T), root, comm);
}

template <class Matrix>
void matrix(Matrix& values, MPI_Comm comm, int root) {
  Eigen::Index extent[2] = {values.rows(), values.cols()};
  plain(extent, comm, root);
  values.resize(extent[0], extent[1]);
  mpi::broadcast(values.data(), static_cast<std::size_t>(values.size()) * sizeof(*values.data()),
                 root, comm);
}

void shapes(ModeShapes& shapes, MPI_Comm comm, int root) {
  ModeShapes::Rows values = shapes.values();
  std::vector<NodeRing> rings = shapes.rings();
  std::vector<CircumferentialWave> waves = shapes.waves();
  matrix(values, comm, root);
  list(rings, comm, root);
  list(waves, comm, root);
  shapes = ModeShapes(std::move(values), std::move(rings), std::move(waves));
}

}  // namespace

void broadcast(Modes& modes, MPI_Comm comm, int root) {
  list(modes.eigenvalues, comm, root);
  list(modes.residuals, comm, root);
  list(modes.pitch_errors, comm, root);
  list(modes.given_decay_rates, comm, root);
  shapes(modes.shapes, comm, root);
  matrix(modes.kinetic_fraction, comm, root);
  matrix(modes.strain_fraction, comm, root);
  plain(modes.surface.order, comm, root);
  std::size_t nodes = modes.surface.nodes.size();
  plain(nodes, comm, root);
  modes.surface.nodes.resize(nodes);
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  mpi::broadcast(modes.surface.nodes.data(), nodes * sizeof(Vec3), root, comm);
  list(modes.surface.faces, comm, root);
  plain(modes.mass, comm, root);
  plain(modes.certificate, comm, root);
}

}  // namespace carillon::solvers::modes
