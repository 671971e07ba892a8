#include "solvers/mesh/tet_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "core/disjoint_sets.hpp"
#include "core/numbers.hpp"
#include "solvers/elements/quadrature.hpp"
#include "solvers/mesh/outward_faces.hpp"

namespace carillon::solvers::mesh {
namespace {

/// Local nodes of the four outward faces in triangle_lattice order.
std::array<std::vector<std::size_t>, 4> face_nodes(int order) {
  const auto& tetrahedron = elements::tetrahedron_lattice(order);
  std::map<std::array<int, 4>, std::size_t> local;
  for (std::size_t n = 0; n < tetrahedron.size(); ++n) local[tetrahedron[n]] = n;
  std::array<std::vector<std::size_t>, 4> nodes;
  for (std::size_t f = 0; f < 4; ++f) {
    for (const auto& tuple : elements::triangle_lattice(order)) {
      std::array<int, 4> at{};
      for (std::size_t k = 0; k < 3; ++k) at[outward_faces[f][k]] = tuple[k];
      nodes[f].push_back(local.at(at));
    }
  }
  return nodes;
}

std::array<Vec3, 4> corners(const TetMesh& mesh, std::size_t e) {
  const auto element = mesh.element(e);
  std::array<Vec3, 4> out;
  for (std::size_t v = 0; v < 4; ++v) out[v] = mesh.nodes[static_cast<std::size_t>(element[v])];
  return out;
}

/// The six interior dihedral angles [rad], one for each edge.
void widen_by_dihedrals(const std::array<Vec3, 4>& v, double& smallest, double& largest) {
  std::array<Vec3, 4> normals;
  for (std::size_t f = 0; f < 4; ++f) {
    const auto& c = outward_faces[f];
    normals[f] = (v[c[1]] - v[c[0]]).cross(v[c[2]] - v[c[0]]);
  }
  for (std::size_t f = 0; f < 4; ++f) {
    for (std::size_t g = f + 1; g < 4; ++g) {
      const double angle = angle_between(normals[f], -normals[g]);
      smallest = std::min(smallest, angle);
      largest = std::max(largest, angle);
    }
  }
}

/// 3 inradius / circumradius; 0 for a flat element.
double radius_ratio(const std::array<Vec3, 4>& v) {
  const double six = std::abs(six_volumes(v[0], v[1], v[2], v[3]));
  double surface = 0;
  for (const auto& c : outward_faces) {
    surface += (v[c[1]] - v[c[0]]).cross(v[c[2]] - v[c[0]]).norm() / 2;
  }
  if (six == 0 || surface == 0) return 0;
  const double inradius = six / (2 * surface);
  const Vec3 a = v[1] - v[0], b = v[2] - v[0], c = v[3] - v[0];
  const Vec3 numerator =
      a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b);
  const double circumradius = numerator.norm() / (2 * six);
  return 3 * inradius / circumradius;
}

/// Integrates det J of the curved elements; exact, since det J has degree 3 (order - 1).
double curved_volume(const TetMesh& mesh) {
  const int order = mesh.order;
  const auto& rule = elements::tetrahedron_rule((3 * (order - 1) + 2) / 2);
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 3>> gradients;
  for (const auto& point : rule.barycentric) {
    Eigen::Matrix<double, Eigen::Dynamic, 4> by_barycentric;
    elements::tetrahedron_shape_functions(order, point, &by_barycentric);
    gradients.emplace_back(by_barycentric.rightCols<3>().colwise() - by_barycentric.col(0));
  }
  Eigen::Matrix<double, 3, Eigen::Dynamic> x(3, elements::nodes_per_tetrahedron(order));
  double volume = 0;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    for (std::size_t n = 0; n < element.size(); ++n) {
      x.col(static_cast<Eigen::Index>(n)) = mesh.nodes[static_cast<std::size_t>(element[n])];
    }
    for (std::size_t q = 0; q < rule.size(); ++q) {
      const Eigen::Matrix3d jacobian = x * gradients[q];
      volume += rule.weights[q] * jacobian.determinant();
    }
  }
  return volume;
}

}  // namespace

double six_volumes(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

double six_volumes(const TetMesh& mesh, std::size_t element) {
  const auto [a, b, c, d] = corners(mesh, element);
  return six_volumes(a, b, c, d);
}

void drop_unused_nodes(TetMesh& mesh) {
  std::vector<std::int32_t> renumbered(mesh.nodes.size(), -1);
  for (const std::int32_t node : mesh.elements) renumbered[static_cast<std::size_t>(node)] = 0;
  std::int32_t next = 0;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    if (renumbered[i] < 0) continue;
    mesh.nodes[static_cast<std::size_t>(next)] = mesh.nodes[i];
    renumbered[i] = next++;
  }
  mesh.nodes.resize(static_cast<std::size_t>(next));
  for (std::int32_t& node : mesh.elements) node = renumbered[static_cast<std::size_t>(node)];
}

std::vector<std::int32_t> boundary_faces(const TetMesh& mesh) {
  struct Face {
    std::array<std::int32_t, 3> key;
    std::size_t owner;  // 4 element + local face
  };
  std::vector<Face> all;
  all.reserve(4 * mesh.element_count());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    for (std::size_t f = 0; f < 4; ++f) {
      const auto& c = outward_faces[f];
      std::array<std::int32_t, 3> key = {element[c[0]], element[c[1]], element[c[2]]};
      std::sort(key.begin(), key.end());
      all.push_back({key, 4 * e + f});
    }
  }
  std::sort(all.begin(), all.end(), [](const Face& a, const Face& b) {
    return a.key != b.key ? a.key < b.key : a.owner < b.owner;
  });
  std::vector<std::size_t> owners;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    while (end < all.size() && all[end].key == all[i].key) ++end;
    if (end == i + 1) owners.push_back(all[i].owner);
    i = end;
  }
  std::sort(owners.begin(), owners.end());

  const auto local = face_nodes(mesh.order);
  std::vector<std::int32_t> faces;
  faces.reserve(owners.size() * static_cast<std::size_t>(elements::nodes_per_face(mesh.order)));
  for (const auto owner : owners) {
    const auto element = mesh.element(owner / 4);
    for (const auto n : local[owner % 4]) faces.push_back(element[n]);
  }
  return faces;
}

std::vector<std::int32_t> face_regions(const TetMesh& mesh) {
  using Corners = std::array<std::int32_t, 3>;
  const auto sorted = [](Corners corners) {
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  std::map<Corners, std::size_t> faces;
  const auto nodes = static_cast<std::size_t>(elements::nodes_per_face(mesh.order));
  for (std::size_t face = 0; face < mesh.face_count(); ++face) {
    // Vertices are the first nodes of faces and elements.
    const std::int32_t* corner = &mesh.faces[face * nodes];
    faces[sorted({corner[0], corner[1], corner[2]})] = face;
  }
  std::vector<std::int32_t> regions(mesh.face_count(), 0);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto corner = mesh.element(e);
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      Corners face{};
      for (std::size_t k = 0, n = 0; k < 4; ++k) {
        if (k != left_out) face[n++] = corner[k];
      }
      const auto found = faces.find(sorted(face));
      if (found != faces.end()) regions[found->second] = mesh.regions[e];
    }
  }
  return regions;
}

bool follows_surface(const MeshQuality& quality, double longest, double wall) {
  constexpr double fiftieth = 0.02;
  return !(quality.hausdorff > std::min(fiftieth * longest, wall / 2)) &&
         !(std::abs(quality.area_error) > fiftieth);
}

MeshQuality measure_quality(const TetMesh& mesh) {
  MeshQuality quality;
  quality.elements = static_cast<std::int64_t>(mesh.element_count());
  quality.nodes = static_cast<std::int64_t>(mesh.nodes.size());
  if (mesh.element_count() == 0) return quality;
  double smallest = std::numbers::pi, largest = 0;
  std::vector<double> ratios;
  ratios.reserve(mesh.element_count());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto v = corners(mesh, e);
    widen_by_dihedrals(v, smallest, largest);
    ratios.push_back(radius_ratio(v));
  }
  quality.min_dihedral_deg = smallest * 180 / std::numbers::pi;
  quality.max_dihedral_deg = largest * 180 / std::numbers::pi;
  quality.min_radius_ratio = *std::min_element(ratios.begin(), ratios.end());
  quality.median_radius_ratio = core::median(std::move(ratios));
  quality.volume = curved_volume(mesh);
  return quality;
}

double mean_thickness(const TetMesh& mesh) {
  SurfaceMesh surface{mesh.nodes, {}};
  const auto per_face = static_cast<std::size_t>(elements::nodes_per_face(mesh.order));
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto* corner = &mesh.faces[f * per_face];
    surface.triangles.push_back({corner[0], corner[1], corner[2]});
  }
  return 2 * curved_volume(mesh) / area(surface);
}

std::vector<std::int32_t> node_components(const TetMesh& mesh) {
  core::DisjointSets joined(mesh.nodes.size());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    for (const auto n : element.subspan(1)) {
      joined.join(static_cast<std::size_t>(element[0]), static_cast<std::size_t>(n));
    }
  }
  std::vector<bool> used(mesh.nodes.size(), false);
  for (const auto n : mesh.elements) used[static_cast<std::size_t>(n)] = true;
  std::vector<std::int32_t> component(mesh.nodes.size(), -1);
  std::int32_t count = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (!used[n]) continue;
    const std::size_t first = joined.find(n);
    component[n] = first == n ? count++ : component[first];
  }
  return component;
}

int count_components(const TetMesh& mesh) {
  const auto component = node_components(mesh);
  return component.empty() ? 0 : *std::max_element(component.begin(), component.end()) + 1;
}

}  // namespace carillon::solvers::mesh
