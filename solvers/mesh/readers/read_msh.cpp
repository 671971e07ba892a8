#include <fmt/core.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "core/error.hpp"
#include "core/files.hpp"
#include "solvers/elements/lagrange.hpp"
#include "solvers/mesh/conformity.hpp"
#include "solvers/mesh/readers/detail/msh_elements.hpp"
#include "solvers/mesh/readers/detail/msh_file.hpp"
#include "solvers/mesh/readers/detail/text_scanner.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

/// Coordinates whose products of six are still numbers.
constexpr double farthest = 1e50;

/// Position in Gmsh's element of each node of ours.
std::vector<std::size_t> gmsh_positions(const std::vector<std::array<int, 4>>& lattice, int order) {
  const auto theirs = gmsh_tetrahedron_lattice(order);
  std::vector<std::size_t> positions;
  for (const auto& tuple : lattice) {
    positions.push_back(
        static_cast<std::size_t>(std::find(theirs.begin(), theirs.end(), tuple) - theirs.begin()));
  }
  return positions;
}

/// The element with corners 0 and 1 exchanged: it was numbered the other way round.
void mirror(std::span<std::int32_t> element, int order) {
  const auto& lattice = elements::tetrahedron_lattice(order);
  const std::vector<std::int32_t> before(element.begin(), element.end());
  for (std::size_t i = 0; i < lattice.size(); ++i) {
    std::array<int, 4> swapped = lattice[i];
    std::swap(swapped[0], swapped[1]);
    const auto at = std::find(lattice.begin(), lattice.end(), swapped) - lattice.begin();
    element[i] = before[static_cast<std::size_t>(at)];
  }
}

/// Derivatives of the shape functions at every node of the reference element.
using Gradients = std::vector<Eigen::Matrix<double, Eigen::Dynamic, 4>>;

Gradients gradients_at_nodes(int order) {
  Gradients gradients;
  for (const auto& tuple : elements::tetrahedron_lattice(order)) {
    const Eigen::Vector4d at(tuple[0], tuple[1], tuple[2], tuple[3]);
    gradients.emplace_back();
    elements::tetrahedron_shape_functions(order, at / order, &gradients.back());
  }
  return gradients;
}

/// Smallest Jacobian determinant at the element's nodes.
double smallest_jacobian(const std::vector<Vec3>& nodes, std::span<const std::int32_t> element,
                         const Gradients& gradients) {
  double smallest = 0;
  for (std::size_t g = 0; g < gradients.size(); ++g) {
    Eigen::Matrix<double, 3, 4> by_barycentric = Eigen::Matrix<double, 3, 4>::Zero();
    for (std::size_t i = 0; i < element.size(); ++i) {
      by_barycentric += nodes[static_cast<std::size_t>(element[i])] *
                        gradients[g].row(static_cast<Eigen::Index>(i));
    }
    Eigen::Matrix3d jacobian;
    for (int k = 0; k < 3; ++k) jacobian.col(k) = by_barycentric.col(k + 1) - by_barycentric.col(0);
    const double determinant = jacobian.determinant();
    if (g == 0 || determinant < smallest) smallest = determinant;
  }
  return smallest;
}

/// Physical groups that are used, in the order of their numbers, as regions.
std::map<std::int64_t, std::int32_t> name_regions(const MshFile& file, TetMesh& mesh) {
  std::map<std::int64_t, std::int32_t> region_of;
  for (const std::int64_t group : file.groups) region_of[group] = 0;
  for (auto& [group, region] : region_of) {
    region = static_cast<std::int32_t>(mesh.region_names.size());
    const auto name = file.volume_names.find(group);
    if (name != file.volume_names.end() && !name->second.empty()) {
      mesh.region_names.push_back(name->second);
    } else {
      mesh.region_names.push_back(group == 0 ? "body" : fmt::format("group_{}", group));
    }
  }
  return region_of;
}

/// Turns elements round that are numbered the wrong way, refuses those that are folded.
void orient(const std::string& path, TetMesh& mesh) {
  const auto size = static_cast<std::size_t>(elements::nodes_per_tetrahedron(mesh.order));
  const Gradients gradients = mesh.order > 1 ? gradients_at_nodes(mesh.order) : Gradients();
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = std::span(mesh.elements).subspan(e * size, size);
    const double volume = six_volumes(mesh, e);
    if (volume < 0) mirror(element, mesh.order);
    if (volume == 0) {
      throw core::InputError(fmt::format("{}: tetrahedron {} has no volume", path, e + 1));
    }
    if (mesh.order > 1 && !(smallest_jacobian(mesh.nodes, element, gradients) > 0)) {
      throw core::InputError(
          fmt::format("{}: curved tetrahedron {} is folded (its Jacobian is not positive)", path,
                      e + 1),
          "mesh again, or optimise the high-order mesh in Gmsh");
    }
  }
}

/// Elements of different fineness that are not matched are torn apart where they meet, and the body
/// would sound far too low without a word.
void refuse_hanging_node(const std::string& path, const TetMesh& mesh) {
  const auto hanging = find_hanging_node(mesh);
  if (!hanging) return;
  const Vec3& at = mesh.nodes[static_cast<std::size_t>(hanging->node)];
  throw core::InputError(
      fmt::format("{}: a corner at ({:.6g}, {:.6g}, {:.6g}) lies inside a face of tetrahedron {}, "
                  "which does not have it as a corner",
                  path, at[0], at[1], at[2], hanging->element + 1),
      "elements that meet must share whole faces: mesh the parts together (in Gmsh: "
      "BooleanFragments), or part them from each other");
}

}  // namespace

TetMesh read_msh(const std::string& path) {
  const MshFile file = parse_msh(path, without_byte_order_mark(core::read_file(path)));
  if (file.order == 0) {
    throw core::InputError(fmt::format("{}: no tetrahedra (the file holds {} other elements)", path,
                                       file.other_elements),
                           "save the volume mesh, or give the surface as .stl, .obj, .off or .ply");
  }
  for (const Vec3& node : file.nodes) {
    if (!(node.cwiseAbs().maxCoeff() < farthest)) {
      throw core::InputError(fmt::format("{}: the coordinates are too large to measure", path));
    }
  }
  TetMesh mesh;
  mesh.order = file.order;
  mesh.nodes = file.nodes;
  const auto region_of = name_regions(file, mesh);
  const auto positions = gmsh_positions(elements::tetrahedron_lattice(file.order), file.order);
  std::set<std::array<std::int32_t, 4>> seen;
  for (std::size_t e = 0; e < file.groups.size(); ++e) {
    const auto theirs = std::span(file.tetrahedra).subspan(e * positions.size(), positions.size());
    std::array<std::int32_t, 4> corners{theirs[0], theirs[1], theirs[2], theirs[3]};
    std::sort(corners.begin(), corners.end());
    if (std::adjacent_find(corners.begin(), corners.end()) != corners.end()) {
      throw core::InputError(fmt::format("{}: tetrahedron {} uses a node twice", path, e + 1));
    }
    // An element of two physical groups stands twice in version 2.2; the first group counts.
    if (!seen.insert(corners).second) continue;
    for (const std::size_t p : positions) mesh.elements.push_back(theirs[p]);
    mesh.regions.push_back(region_of.at(file.groups[e]));
  }
  drop_unused_nodes(mesh);
  orient(path, mesh);
  refuse_hanging_node(path, mesh);
  mesh.faces = boundary_faces(mesh);
  return mesh;
}

}  // namespace carillon::solvers::mesh::readers
