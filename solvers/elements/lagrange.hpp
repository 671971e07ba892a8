#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace carillon::solvers::elements {

constexpr int nodes_per_tetrahedron(int order) {
  return (order + 1) * (order + 2) * (order + 3) / 6;
}
constexpr int nodes_per_face(int order) {
  return (order + 1) * (order + 2) / 2;
}

/// Orders 1 to 5 are known: bodies are solved at 1 to 4, and order 5 measures the error of order 4.
///
/// Where the nodes of a Lagrange tetrahedron lie: barycentric coordinates times the order, each a
/// 4-tuple that sums to the order. Nodes come as the 4 vertices; then order-1 nodes on each edge
/// (01)(02)(03)(12)(13)(23), walking from its first vertex; then those inside each face
/// (012)(013)(023)(123); then those inside. This is the node order of every TetMesh element.
const std::vector<std::array<int, 4>>& tetrahedron_lattice(int order);

/// The same for a triangle: 3 vertices, edges (01)(02)(12), inside; 3-tuples that sum to order.
const std::vector<std::array<int, 3>>& triangle_lattice(int order);

/// Values of the Lagrange shape functions (Silvester's products) of a tetrahedron at barycentric
/// coordinates, and their derivatives by the 4 barycentric coordinates.
/// @return nodes values; gradient is nodes x 4 when not null
Eigen::VectorXd tetrahedron_shape_functions(int order, const Eigen::Vector4d& barycentric,
                                            Eigen::Matrix<double, Eigen::Dynamic, 4>* gradient);

/// The same on a triangle: nodes values, nodes x 3 derivatives.
Eigen::VectorXd triangle_shape_functions(int order, const Eigen::Vector3d& barycentric,
                                         Eigen::Matrix<double, Eigen::Dynamic, 3>* gradient);

}  // namespace carillon::solvers::elements
