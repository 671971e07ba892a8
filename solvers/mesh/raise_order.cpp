#include "solvers/mesh/raise_order.hpp"

#include <fmt/core.h>

#include <utility>

#include "core/error.hpp"

namespace carillon::solvers::mesh {

elements::NodeNumbering numbering_at(const TetMesh& mesh, int order) {
  std::vector<std::int32_t> number(mesh.nodes.size(), -1);
  std::int32_t vertices = 0;
  std::vector<elements::Corners> corners(mesh.element_count());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    for (std::size_t i = 0; i < 4; ++i) {
      std::int32_t& n = number[static_cast<std::size_t>(mesh.element(e)[i])];
      if (n < 0) n = vertices++;
      corners[e][i] = n;
    }
  }
  return elements::number_nodes(corners, vertices, order);
}

TetMesh raise_order(const TetMesh& mesh, int order) {
  return raise_order(mesh, order, numbering_at(mesh, order));
}

TetMesh raise_order(const TetMesh& mesh, int order, elements::NodeNumbering numbering) {
  TetMesh raised;
  raised.order = order;
  raised.regions = mesh.regions;
  raised.region_names = mesh.region_names;
  const auto& lattice = elements::tetrahedron_lattice(order);
  std::vector<Eigen::VectorXd> shapes;
  for (const auto& at : lattice) {
    const Eigen::Vector4d barycentric = Eigen::Vector4d(at[0], at[1], at[2], at[3]) / order;
    shapes.push_back(elements::tetrahedron_shape_functions(mesh.order, barycentric, nullptr));
  }
  for (const std::int64_t use : numbering.first_use) {
    const auto element = mesh.element(static_cast<std::size_t>(use) / lattice.size());
    const Eigen::VectorXd& shape = shapes[static_cast<std::size_t>(use) % lattice.size()];
    Vec3 point = Vec3::Zero();
    for (std::size_t i = 0; i < element.size(); ++i) {
      point +=
          shape[static_cast<Eigen::Index>(i)] * mesh.nodes[static_cast<std::size_t>(element[i])];
    }
    raised.nodes.push_back(point);
  }
  raised.elements = std::move(numbering.elements);
  raised.faces = boundary_faces(raised);
  return raised;
}

TetMesh next_order(const TetMesh& mesh) {
  TetMesh next = raise_order(mesh, mesh.order + 1);
  if (mesh.finer_nodes.empty()) return next;
  if (mesh.finer_nodes.size() != next.nodes.size()) {
    throw core::InputError(fmt::format("the mesh has {} nodes of the next order and needs {}",
                                       mesh.finer_nodes.size(), next.nodes.size()));
  }
  if (!mesh.finer_gaps.empty() && mesh.finer_gaps.size() != next.nodes.size()) {
    throw core::InputError(fmt::format("the mesh has {} gaps for {} nodes of the next order",
                                       mesh.finer_gaps.size(), next.nodes.size()));
  }
  next.nodes = mesh.finer_nodes;
  return next;
}

}  // namespace carillon::solvers::mesh
