#include "solvers/modes/modes_broadcast.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <type_traits>

namespace carillon::solvers::modes {
namespace {

/// Any number of bytes, in pieces that MPI can count.
void bytes(void* data, std::size_t count, MPI_Comm comm) {
  constexpr std::size_t most = std::numeric_limits<int>::max() / 2;
  auto* next = static_cast<std::byte*>(data);
  while (count > 0) {
    const auto piece = std::min(count, most);
    MPI_Bcast(next, static_cast<int>(piece), MPI_BYTE, 0, comm);
    next += piece;
    count -= piece;
  }
}

template <class T>
void plain(T& value, MPI_Comm comm) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes(&value, sizeof(T), comm);
}

template <class T>
void list(std::vector<T>& values, MPI_Comm comm) {
  std::size_t count = values.size();
  plain(count, comm);
  values.resize(count);
  bytes(values.data(), count * sizeof(T), comm);
}

template <class Matrix>
void matrix(Matrix& values, MPI_Comm comm) {
  Eigen::Index extent[2] = {values.rows(), values.cols()};
  plain(extent, comm);
  values.resize(extent[0], extent[1]);
  bytes(values.data(), static_cast<std::size_t>(values.size()) * sizeof(*values.data()), comm);
}

}  // namespace

void broadcast(Modes& modes, MPI_Comm comm) {
  list(modes.eigenvalues, comm);
  list(modes.residuals, comm);
  list(modes.pitch_errors, comm);
  list(modes.harmonics, comm);
  matrix(modes.shapes, comm);
  matrix(modes.kinetic_share, comm);
  matrix(modes.strain_share, comm);
  plain(modes.surface.order, comm);
  std::size_t nodes = modes.surface.nodes.size();
  plain(nodes, comm);
  modes.surface.nodes.resize(nodes);
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  if (nodes > 0) bytes(modes.surface.nodes[0].data(), nodes * sizeof(Vec3), comm);
  list(modes.surface.faces, comm);
  plain(modes.mass, comm);
  plain(modes.certificate, comm);
}

}  // namespace carillon::solvers::modes
