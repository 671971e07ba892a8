#include "solvers/eigen/detail/order_transfer.hpp"

#include <Eigen/LU>
#include <vector>

#include "solvers/elements/lagrange.hpp"
#include "solvers/mesh/raise_order.hpp"

namespace carillon::solvers::eigen {
namespace {

/// How far nodes of the next order lie off the solved order's elements; exactly zero where that is
/// rounding [m].
std::vector<Vec3> offsets(const mesh::TetMesh& mesh, const mesh::TetMesh& finer, double length) {
  constexpr double rounding = 1e-12;
  std::vector<Vec3> out = mesh::raise_order(mesh, finer.order).nodes;
  for (std::size_t n = 0; n < out.size(); ++n) {
    out[n] = finer.nodes[n] - out[n];
    if (out[n].norm() < rounding * length) out[n].setZero();
  }
  return out;
}

}  // namespace

OrderTransfer::OrderTransfer(const mesh::TetMesh& mesh, const assembly::System& system,
                             const FinerSpace& finer, MPI_Comm comm)
    : mesh_(mesh), system_(system), finer_(finer), comm_(comm) {
  const mesh::TetMesh& next = finer.mesh();
  const auto& lattice = elements::tetrahedron_lattice(next.order);
  const auto coarse_nodes = elements::nodes_per_tetrahedron(mesh.order);
  const auto fine_nodes = static_cast<Eigen::Index>(lattice.size());
  Eigen::MatrixXd values(coarse_nodes, fine_nodes);
  std::vector<Eigen::MatrixXd> slopes;  // by the last three barycentric coordinates
  for (std::size_t k = 0; k < lattice.size(); ++k) {
    const auto& at = lattice[k];
    const Eigen::Vector4d barycentric = Eigen::Vector4d(at[0], at[1], at[2], at[3]) / next.order;
    Eigen::Matrix<double, Eigen::Dynamic, 4> gradient;
    values.col(static_cast<Eigen::Index>(k)) =
        elements::tetrahedron_shape_functions(mesh.order, barycentric, &gradient);
    slopes.push_back(gradient.rightCols<3>().colwise() - gradient.col(0));
  }
  std::vector<std::int32_t> user(next.nodes.size(), -1), uses(next.nodes.size(), 0);
  for (std::size_t e = 0; e < next.element_count(); ++e) {
    for (const auto n : next.element(e)) {
      const auto node = static_cast<std::size_t>(n);
      if (user[node] < 0) user[node] = static_cast<std::int32_t>(e);
      ++uses[node];
    }
  }
  const auto offset = offsets(mesh, next, system.scales.length);
  elements::Coordinates nodes;
  for (const auto e : finer.own_elements()) {
    const auto element = next.element(e);
    auto& weights = weights_.emplace_back(Eigen::MatrixXd::Zero(coarse_nodes, fine_nodes));
    assembly::gather(mesh, e, system.scales, nodes);
    for (Eigen::Index k = 0; k < fine_nodes; ++k) {
      const auto node = static_cast<std::size_t>(element[static_cast<std::size_t>(k)]);
      if (user[node] == static_cast<std::int32_t>(e)) weights.col(k) = values.col(k);
      if (offset[node].isZero(0)) continue;
      const auto& slope = slopes[static_cast<std::size_t>(k)];
      const Eigen::Matrix3d jacobian = nodes * slope;
      const Vec3 along = jacobian.inverse() * offset[node] / system.scales.length;
      weights.col(k) += slope * along / uses[node];
    }
  }
}

Fields OrderTransfer::gather_owned(const Eigen::Ref<const Eigen::MatrixXd>& owned) const {
  Fields out = Fields::Zero(owned.cols(), 3 * static_cast<Eigen::Index>(mesh_.nodes.size()));
  add_owned(system_, owned, out);
  sum_over_ranks(out, comm_);
  return out;
}

void OrderTransfer::add_prolonged(const Eigen::Ref<const Eigen::MatrixXd>& owned,
                                  Fields& out) const {
  const auto coarse = gather_owned(owned);
  const auto own = finer_.own_elements();
  Fields local, product;
  for (std::size_t k = 0; k < own.size(); ++k) {
    const auto& weights = weights_[k];
    gather(coarse, mesh_.element(own[k]), local);
    product.resize(coarse.rows(), 3 * weights.cols());
    by_node(product).noalias() = by_node(local) * weights;
    scatter_add(product, finer_.mesh().element(own[k]), out);
  }
}

Fields OrderTransfer::prolong(const Eigen::Ref<const Eigen::MatrixXd>& owned) const {
  Fields out =
      Fields::Zero(owned.cols(), 3 * static_cast<Eigen::Index>(finer_.mesh().nodes.size()));
  add_prolonged(owned, out);
  sum_over_ranks(out, comm_);
  return out;
}

Eigen::MatrixXd OrderTransfer::restriction(const Fields& fine) const {
  Fields coarse = Fields::Zero(fine.rows(), 3 * static_cast<Eigen::Index>(mesh_.nodes.size()));
  const auto own = finer_.own_elements();
  Fields local, product;
  for (std::size_t k = 0; k < own.size(); ++k) {
    const auto& weights = weights_[k];
    gather(fine, finer_.mesh().element(own[k]), local);
    product.resize(fine.rows(), 3 * weights.rows());
    by_node(product).noalias() = by_node(local) * weights.transpose();
    scatter_add(product, mesh_.element(own[k]), coarse);
  }
  sum_over_ranks(coarse, comm_);
  return owned_rows(system_, coarse);
}

}  // namespace carillon::solvers::eigen
