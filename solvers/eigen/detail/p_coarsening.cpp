#include "solvers/eigen/detail/p_coarsening.hpp"

#include <algorithm>
#include <cmath>

#include "mpi/comm.hpp"
#include "solvers/mesh/raise_order.hpp"

namespace carillon::solvers::eigen {
namespace {

/// Values at the nodes of a tetrahedron of order `from` of the shape functions of order `to`.
Eigen::MatrixXd reference_prolongation(int from, int to) {
  const auto& lattice = elements::tetrahedron_lattice(from);
  Eigen::MatrixXd out(elements::nodes_per_tetrahedron(from), elements::nodes_per_tetrahedron(to));
  for (Eigen::Index n = 0; n < out.rows(); ++n) {
    const auto& at = lattice[static_cast<std::size_t>(n)];
    const Eigen::Vector4d barycentric = Eigen::Vector4d(at[0], at[1], at[2], at[3]) / from;
    out.row(n) = elements::tetrahedron_shape_functions(to, barycentric, nullptr).transpose();
  }
  return out;
}

/// The three components of each node's row and column.
Eigen::MatrixXd for_components(const Eigen::MatrixXd& nodes) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(3 * nodes.rows(), 3 * nodes.cols());
  for (Eigen::Index a = 0; a < nodes.rows(); ++a) {
    for (Eigen::Index b = 0; b < nodes.cols(); ++b) {
      out.block<3, 3>(3 * a, 3 * b).diagonal().setConstant(nodes(a, b));
    }
  }
  return out;
}

/// Sums the restricted elements into the rows that this rank owns.
void sum_elements(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                  PLevel& level) {
  auto& system = level.system;
  const auto constants = assembly::elastic_constants(regions, system.scales);
  const Eigen::MatrixXd scalar = reference_prolongation(mesh.order, level.mesh.order);
  const Eigen::MatrixXd vector = for_components(scalar);
  elements::ElementKernel kernel(mesh.order);
  elements::Coordinates nodes;
  Eigen::MatrixXd k, m;
  for (const auto e : assembly::elements_of_rank(level.mesh, system)) {
    assembly::gather(mesh, e, system.scales, nodes);
    kernel.place(nodes);
    const auto& material = constants[static_cast<std::size_t>(mesh.regions[e])];
    kernel.stiffness(material, k);
    kernel.mass(material.density, m);
    assembly::add_element(level.mesh.element(e), vector.transpose() * k * vector,
                          scalar.transpose() * m * scalar, system);
  }
}

/// Rows of the prolongation of the finer nodes that this rank owns.
MatHandle prolongation(const mesh::TetMesh& finer, const assembly::Partition& finer_partition,
                       const PLevel& level, int rank, MPI_Comm comm) {
  const Eigen::MatrixXd weights = reference_prolongation(finer.order, level.mesh.order);
  const auto begin = finer_partition.first[static_cast<std::size_t>(rank)];
  const auto rows = finer_partition.owned(rank);
  std::vector<std::int64_t> place(static_cast<std::size_t>(rows), -1);
  const auto per_element = static_cast<std::size_t>(elements::nodes_per_tetrahedron(finer.order));
  for (std::size_t at = 0; at < finer.elements.size(); ++at) {
    const auto number = finer_partition.number[static_cast<std::size_t>(finer.elements[at])];
    if (number < begin || number >= begin + rows) continue;
    auto& first = place[static_cast<std::size_t>(number - begin)];
    if (first < 0) first = static_cast<std::int64_t>(at);
  }
  std::vector<PetscInt> first = {0}, column;
  std::vector<double> value;
  for (const auto at : place) {
    const auto element = level.mesh.element(static_cast<std::size_t>(at) / per_element);
    const auto local = static_cast<Eigen::Index>(static_cast<std::size_t>(at) % per_element);
    std::vector<std::pair<PetscInt, double>> entries;
    for (std::size_t n = 0; n < element.size(); ++n) {
      const double weight = weights(local, static_cast<Eigen::Index>(n));
      if (std::abs(weight) < 1e-12) continue;
      entries.emplace_back(level.system.partition.number[static_cast<std::size_t>(element[n])],
                           weight);
    }
    std::sort(entries.begin(), entries.end());
    for (const auto& [number, weight] : entries) {
      column.push_back(number);
      value.push_back(weight);
    }
    first.push_back(static_cast<PetscInt>(column.size()));
  }
  MatHandle scalar, out;
  libraries::check(MatCreateMPIAIJWithArrays(comm, rows, level.system.graph.rows(), PETSC_DETERMINE,
                                             PETSC_DETERMINE, first.data(), column.data(),
                                             value.data(), scalar.put()));
  libraries::check(MatCreateMAIJ(scalar.get(), 3, out.put()));
  return out;
}

}  // namespace

PLevel coarsen(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
               const mesh::TetMesh& finer, const assembly::Partition& finer_partition, int order,
               MPI_Comm comm) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  PLevel level;
  mpi::agreed_in_group(comm, [&] {
    level.mesh = mesh::raise_order(mesh, order);
    level.mesh.faces.clear();
    level.system = assembly::empty_system(level.mesh, assembly::scales_of(mesh, regions),
                                          assembly::partition(level.mesh, ranks), comm);
    sum_elements(mesh, regions, level);
  });
  level.prolongation = prolongation(finer, finer_partition, level, rank, comm);
  return level;
}

}  // namespace carillon::solvers::eigen
