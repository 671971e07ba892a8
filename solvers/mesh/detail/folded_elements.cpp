#include "solvers/mesh/detail/folded_elements.hpp"

#include <Eigen/LU>

#include "solvers/elements/quadrature.hpp"

namespace carillon::solvers::mesh {
namespace {

/// Derivatives of the shape functions where the sign of the Jacobian is sampled: the nodes of
/// order 4 and the points of a rule that integrates the stiffness.
///
/// @return nodes x (3 points)
Eigen::MatrixXd sampled_gradients(int order) {
  std::vector<Eigen::Vector4d> points = elements::tetrahedron_rule(order + 1).barycentric;
  for (const auto& at : elements::tetrahedron_lattice(4))
    points.emplace_back(at[0] / 4.0, at[1] / 4.0, at[2] / 4.0, at[3] / 4.0);
  Eigen::MatrixXd gradients(elements::nodes_per_tetrahedron(order),
                            3 * static_cast<Eigen::Index>(points.size()));
  Eigen::Index column = 0;
  for (const auto& point : points) {
    Eigen::Matrix<double, Eigen::Dynamic, 4> by_barycentric;
    elements::tetrahedron_shape_functions(order, point, &by_barycentric);
    gradients.middleCols<3>(column) =
        by_barycentric.rightCols<3>().colwise() - by_barycentric.col(0);
    column += 3;
  }
  return gradients;
}

}  // namespace

std::vector<std::size_t> folded_elements(const TetMesh& mesh) {
  constexpr double min_fraction = 0.05;
  const Eigen::MatrixXd gradients = sampled_gradients(mesh.order);
  std::vector<std::size_t> folded;
  Eigen::Matrix3Xd nodes(3, gradients.rows()), jacobians;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    for (std::size_t n = 0; n < element.size(); ++n)
      nodes.col(static_cast<Eigen::Index>(n)) = mesh.nodes[static_cast<std::size_t>(element[n])];
    jacobians.noalias() = nodes * gradients;
    const double min_determinant = min_fraction * six_volumes(mesh, e);
    for (Eigen::Index c = 0; c < jacobians.cols(); c += 3)
      if (jacobians.middleCols<3>(c).determinant() < min_determinant) {
        folded.push_back(e);
        break;
      }
  }
  return folded;
}

}  // namespace carillon::solvers::mesh
