#include "solvers/assembly/fields.hpp"

#include <algorithm>

#include "mpi/comm.hpp"

namespace carillon::solvers::assembly {
namespace {

/// Fields treated at a time: every rank holds those of all nodes.
constexpr Eigen::Index max_values = 1 << 25, widest_batch = 256, narrowest_batch = 16;

/// Products of one batch, written to `out`'s columns from `first`.
void write_products(const mesh::TetMesh& mesh, const System& system,
                    std::span<const std::vector<elements::ElasticConstants>> materials,
                    const NodeFields& fields, Eigen::Index first,
                    std::vector<Eigen::MatrixXd>& out) {
  const auto count = fields.cols() / 3;
  const auto begin = system.graph.begin, end = begin + system.graph.rows();
  elements::ElementKernel kernel(mesh.order);
  const Eigen::Index nodes = kernel.nodes();
  elements::Coordinates positions;
  Eigen::MatrixXd u(3 * nodes, count), k, product(3 * nodes, count);
  std::vector<std::int32_t> numbers(static_cast<std::size_t>(nodes));
  std::vector<NodeFields> sums(materials.size(),
                               NodeFields::Zero(system.graph.rows(), fields.cols()));
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    bool owned = false;
    for (std::size_t n = 0; n < element.size(); ++n) {
      numbers[n] = system.partition.number[static_cast<std::size_t>(element[n])];
      owned = owned || (numbers[n] >= begin && numbers[n] < end);
    }
    if (!owned) continue;
    gather(mesh, e, system.scales, positions);
    kernel.place(positions);
    for (Eigen::Index n = 0; n < nodes; ++n) {
      u.middleRows<3>(3 * n) = Eigen::Map<const Eigen::Matrix3Xd>(
          fields.row(numbers[static_cast<std::size_t>(n)]).data(), 3, count);
    }
    for (std::size_t m = 0; m < materials.size(); ++m) {
      kernel.stiffness(materials[m][static_cast<std::size_t>(mesh.regions[e])], k);
      product.noalias() = k * u;
      for (Eigen::Index n = 0; n < nodes; ++n) {
        const auto row = numbers[static_cast<std::size_t>(n)] - begin;
        if (row < 0 || row >= system.graph.rows()) continue;
        Eigen::Map<Eigen::Matrix3Xd>(sums[m].row(row).data(), 3, count) +=
            product.middleRows<3>(3 * n);
      }
    }
  }
  for (std::size_t m = 0; m < materials.size(); ++m) {
    for (Eigen::Index f = 0; f < count; ++f) {
      for (Eigen::Index row = 0; row < system.graph.rows(); ++row) {
        out[m].col(first + f).segment<3>(3 * row) = sums[m].row(row).segment<3>(3 * f).transpose();
      }
    }
  }
}

}  // namespace

NodeFields gather_fields(const System& system, const Eigen::Ref<const Eigen::MatrixXd>& fields,
                         MPI_Comm comm) {
  const auto rows = system.graph.rows();
  const auto columns = 3 * fields.cols();
  int size = 1;
  MPI_Comm_size(comm, &size);
  NodeFields own, all;
  std::vector<int> counts, starts;
  mpi::agreed_in_group(comm, [&] {
    own.resize(rows, columns);
    for (Eigen::Index f = 0; f < fields.cols(); ++f) {
      for (Eigen::Index row = 0; row < rows; ++row) {
        own.row(row).segment<3>(3 * f) = fields.col(f).segment<3>(3 * row).transpose();
      }
    }
    if (size == 1) return;
    // Memory for everything before anybody waits in the gathering.
    all.resize(system.partition.node_count(), columns);
    for (int r = 0; r < size; ++r) {
      counts.push_back(system.partition.owned(r));
      starts.push_back(system.partition.first[static_cast<std::size_t>(r)]);
    }
  });
  if (size == 1) return own;
  // Counted in rows, so that the counts stay far from 2^31.
  MPI_Datatype row_type;
  MPI_Type_contiguous(static_cast<int>(columns), MPI_DOUBLE, &row_type);
  MPI_Type_commit(&row_type);
  MPI_Allgatherv(own.data(), rows, row_type, all.data(), counts.data(), starts.data(), row_type,
                 comm);
  MPI_Type_free(&row_type);
  return all;
}

std::vector<Eigen::MatrixXd> apply_stiffness(
    const mesh::TetMesh& mesh, const System& system,
    std::span<const std::vector<elements::ElasticConstants>> materials,
    const Eigen::Ref<const Eigen::MatrixXd>& fields, MPI_Comm comm) {
  std::vector<Eigen::MatrixXd> out;
  mpi::agreed_in_group(comm, [&] {
    out.assign(materials.size(), Eigen::MatrixXd(system.owned_unknowns(), fields.cols()));
  });
  const auto fitting = max_values / std::max<Eigen::Index>(1, system.unknowns());
  const auto batch = std::clamp(fitting, narrowest_batch, widest_batch);
  for (Eigen::Index first = 0; first < fields.cols(); first += batch) {
    const auto count = std::min(batch, fields.cols() - first);
    const auto gathered = gather_fields(system, fields.middleCols(first, count), comm);
    mpi::agreed_in_group(comm,
                         [&] { write_products(mesh, system, materials, gathered, first, out); });
  }
  for (auto& product : out) hold(system, product);
  return out;
}

}  // namespace carillon::solvers::assembly
