#include "solvers/modes/modes_broadcast.hpp"

#include <cstddef>
#include <type_traits>

#include "mpi/comm.hpp"

namespace carillon::solvers::modes {
namespace {

template <class T>
void plain(T& value, MPI_Comm comm) {
  static_assert(std::is_trivially_copyable_v<T>);
  mpi::broadcast(&value, sizeof(T), 0, comm);
}

template <class T>
void list(std::vector<T>& values, MPI_Comm comm) {
  std::size_t count = values.size();
  plain(count, comm);
  values.resize(count);
  mpi::broadcast(values.data(), count * sizeof(T), 0, comm);
}

template <class Matrix>
void matrix(Matrix& values, MPI_Comm comm) {
  Eigen::Index extent[2] = {values.rows(), values.cols()};
  plain(extent, comm);
  values.resize(extent[0], extent[1]);
  mpi::broadcast(values.data(), static_cast<std::size_t>(values.size()) * sizeof(*values.data()), 0,
                 comm);
}

}  // namespace

void broadcast(Modes& modes, MPI_Comm comm) {
  list(modes.eigenvalues, comm);
  list(modes.residuals, comm);
  list(modes.pitch_errors, comm);
  list(modes.harmonics, comm);
  matrix(modes.shapes, comm);
  matrix(modes.kinetic_fraction, comm);
  matrix(modes.strain_fraction, comm);
  plain(modes.surface.order, comm);
  std::size_t nodes = modes.surface.nodes.size();
  plain(nodes, comm);
  modes.surface.nodes.resize(nodes);
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  mpi::broadcast(modes.surface.nodes.data(), nodes * sizeof(Vec3), 0, comm);
  list(modes.surface.faces, comm);
  plain(modes.mass, comm);
  plain(modes.certificate, comm);
}

}  // namespace carillon::solvers::modes
