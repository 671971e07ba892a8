#include "mesh_checks.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>

#include "solvers/elements/quadrature.hpp"

namespace carillon::test {
namespace {

using solvers::mesh::TetMesh;

const Vec3& node(const TetMesh& mesh, std::int32_t n) {
  return mesh.nodes[static_cast<std::size_t>(n)];
}

/// Integrates over the curved boundary: calls visit(position, area vector times weight).
template <class Visit>
void integrate_boundary(const TetMesh& mesh, const Visit& visit) {
  const int points = 2 * mesh.order;
  Eigen::VectorXd x, wx, y, wy;
  solvers::elements::gauss_jacobi(points, 1, x, wx);
  solvers::elements::gauss_jacobi(points, 0, y, wy);
  const auto per_face = static_cast<std::size_t>(solvers::elements::nodes_per_face(mesh.order));
  for (Eigen::Index i = 0; i < points; ++i)
    for (Eigen::Index j = 0; j < points; ++j) {
      // Duffy's square: b1 = x, b2 = (1 - x) y.
      const Eigen::Vector3d b((1 - x[i]) * (1 - y[j]), x[i], (1 - x[i]) * y[j]);
      Eigen::Matrix<double, Eigen::Dynamic, 3> gradient;
      const Eigen::VectorXd shape =
          solvers::elements::triangle_shape_functions(mesh.order, b, &gradient);
      for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        Vec3 at = Vec3::Zero(), du = Vec3::Zero(), dv = Vec3::Zero();
        for (std::size_t k = 0; k < per_face; ++k) {
          const auto row = static_cast<Eigen::Index>(k);
          const Vec3& p = node(mesh, mesh.faces[f * per_face + k]);
          at += shape[row] * p;
          du += (gradient(row, 1) - gradient(row, 0)) * p;
          dv += (gradient(row, 2) - gradient(row, 0)) * p;
        }
        visit(at, Vec3(wx[i] * wy[j] * du.cross(dv)));
      }
    }
}

std::string jacobian_faults(const TetMesh& mesh) {
  const auto& rule = solvers::elements::tetrahedron_rule(2 * mesh.order);
  const auto per_element = solvers::elements::nodes_per_tetrahedron(mesh.order);
  Eigen::Matrix<double, 3, Eigen::Dynamic> nodes(3, per_element);
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 4>> gradients(rule.size());
  for (std::size_t q = 0; q < rule.size(); ++q)
    solvers::elements::tetrahedron_shape_functions(mesh.order, rule.barycentric[q], &gradients[q]);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    for (int n = 0; n < per_element; ++n)
      nodes.col(n) = node(mesh, mesh.element(e)[static_cast<std::size_t>(n)]);
    for (const auto& gradient : gradients) {
      const Eigen::Matrix<double, 3, 4> d = nodes * gradient;
      const Eigen::Matrix3d jacobian = d.rightCols<3>().colwise() - d.col(0);
      if (!(jacobian.determinant() > 0))
        return fmt::format("element {} has a Jacobian of {:.3g}", e, jacobian.determinant());
    }
  }
  return "";
}

/// Nodes of the three edges of a face, each walked counter-clockwise, ends included.
std::array<std::vector<std::int32_t>, 3> edges_of(const TetMesh& mesh, std::size_t face) {
  const auto& lattice = solvers::elements::triangle_lattice(mesh.order);
  const auto per_face = lattice.size();
  std::array<std::vector<std::int32_t>, 3> edges;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    std::map<int, std::int32_t> walk;  // by weight of the end corner
    for (std::size_t k = 0; k < per_face; ++k)
      if (lattice[k][i] + lattice[k][j] == mesh.order)
        walk[lattice[k][j]] = mesh.faces[face * per_face + k];
    for (const auto& [weight, n] : walk) edges[i].push_back(n);
  }
  return edges;
}

std::string edge_faults(const TetMesh& mesh) {
  std::map<std::vector<std::int32_t>, int> uses;
  for (std::size_t f = 0; f < mesh.face_count(); ++f)
    for (const auto& edge : edges_of(mesh, f)) ++uses[edge];
  for (const auto& [edge, count] : uses) {
    const std::vector<std::int32_t> back(edge.rbegin(), edge.rend());
    const auto other = uses.find(back);
    if (count != 1 || other == uses.end() || other->second != 1)
      return fmt::format("the boundary edge {}-{} is used {} times one way and {} the other",
                         edge.front(), edge.back(), count, other == uses.end() ? 0 : other->second);
  }
  return "";
}

}  // namespace

std::string mesh_faults(const TetMesh& mesh) {
  std::vector<bool> used(mesh.nodes.size(), false);
  for (std::int32_t n : mesh.elements) {
    if (n < 0 || static_cast<std::size_t>(n) >= mesh.nodes.size()) return "a node out of range";
    used[static_cast<std::size_t>(n)] = true;
  }
  if (std::find(used.begin(), used.end(), false) != used.end()) return "a node without element";
  for (const auto& p : mesh.nodes)
    if (!p.allFinite()) return "a node that is not finite";
  if (mesh.region_names.size() != 1) return "not one region";
  auto fault = jacobian_faults(mesh);
  if (fault.empty()) fault = edge_faults(mesh);
  if (!fault.empty()) return fault;
  const double inside = boundary_volume(mesh), filled = solvers::mesh::measure_quality(mesh).volume;
  if (std::abs(inside - filled) > 1e-9 * filled)
    return fmt::format("faces enclose {:.12g} m^3, elements fill {:.12g} m^3", inside, filled);
  return "";
}

int boundary_euler_number(const TetMesh& mesh) {
  const auto per_face = static_cast<std::size_t>(solvers::elements::nodes_per_face(mesh.order));
  std::set<std::int32_t> corners;
  for (std::size_t f = 0; f < mesh.face_count(); ++f)
    for (std::size_t i = 0; i < 3; ++i) corners.insert(mesh.faces[f * per_face + i]);
  const auto faces = static_cast<int>(mesh.face_count());
  return static_cast<int>(corners.size()) - faces / 2;  // three half-edges to a face
}

double boundary_area(const TetMesh& mesh) {
  double area = 0;
  integrate_boundary(mesh, [&](const Vec3&, const Vec3& vector) { area += vector.norm(); });
  return area;
}

double boundary_volume(const TetMesh& mesh) {
  double volume = 0;
  integrate_boundary(mesh,
                     [&](const Vec3& at, const Vec3& vector) { volume += at.dot(vector) / 3; });
  return volume;
}

double longest_edge(const TetMesh& mesh) {
  double longest = 0;
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        longest = std::max(
            longest, (node(mesh, mesh.element(e)[i]) - node(mesh, mesh.element(e)[j])).norm());
  return longest;
}

std::vector<std::int32_t> boundary_nodes(const TetMesh& mesh) {
  const std::set<std::int32_t> nodes(mesh.faces.begin(), mesh.faces.end());
  return {nodes.begin(), nodes.end()};
}

bool same_bytes(const TetMesh& a, const TetMesh& b) {
  const auto same = [](const std::vector<Vec3>& x, const std::vector<Vec3>& y) {
    return std::ranges::equal(std::as_bytes(std::span(x)), std::as_bytes(std::span(y)));
  };
  return a.order == b.order && a.elements == b.elements && a.faces == b.faces &&
         same(a.nodes, b.nodes) && same(a.finer_nodes, b.finer_nodes) &&
         same(a.finer_gaps, b.finer_gaps);
}

}  // namespace carillon::test
