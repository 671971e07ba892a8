#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "solvers/elements/lagrange.hpp"
#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh {

/// Isoparametric Lagrange tetrahedra of one order: boundary nodes lie on the true surface.
struct TetMesh {
  int order = 1;
  std::vector<Vec3> nodes;                ///< [m]
  std::vector<std::int32_t> elements;     ///< element_count() x nodes_per_tetrahedron(order)
  std::vector<std::int32_t> regions;      ///< region of each element, index into region_names
  std::vector<std::string> region_names;  ///< at least one; MSH physical groups keep their names
  std::vector<std::int32_t> faces;        ///< boundary faces seen counter-clockwise from outside,
                                          ///< n x nodes_per_face(order), triangle_lattice order
  /// Nodes of the same elements at order + 1 on the true surface [m], numbered by numbering_at();
  /// what errors are measured against. Empty: the mesh's own curved elements are the truth.
  std::vector<Vec3> finer_nodes;
  /// How far each of finer_nodes is from where it should be [m], because an element would fold
  /// there, or where one does also because keep_volume() moved it. Empty: no element would.
  std::vector<Vec3> finer_gaps;

  std::size_t element_count() const { return regions.size(); }
  std::size_t face_count() const {
    return faces.size() / static_cast<std::size_t>(elements::nodes_per_face(order));
  }
  std::span<const std::int32_t> element(std::size_t e) const {
    const auto n = static_cast<std::size_t>(elements::nodes_per_tetrahedron(order));
    return std::span(elements).subspan(e * n, n);
  }
};

/// Six times the volume of a tetrahedron [m^3]; negative when it is inside out.
double six_volumes(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
/// The same between an element's corners.
double six_volumes(const TetMesh& mesh, std::size_t element);

/// Drops the nodes that no element uses; the others keep their order. Faces and finer nodes must
/// not be there yet, or be made anew.
void drop_unused_nodes(TetMesh& mesh);

/// Boundary faces of the elements (those that one element owns), oriented outward, as
/// TetMesh::faces.
std::vector<std::int32_t> boundary_faces(const TetMesh& mesh);

/// The region that the element behind each boundary face belongs to, in the order of `mesh.faces`.
std::vector<std::int32_t> face_regions(const TetMesh& mesh);

/// Shape and size of the elements, judged by their corners, and how well they keep their body.
struct MeshQuality {
  std::int64_t elements = 0;
  std::int64_t nodes = 0;
  double min_dihedral_deg = 0;
  double max_dihedral_deg = 0;
  double min_radius_ratio = 0;  ///< 3 x inradius / circumradius: 1 for the regular tetrahedron
  double median_radius_ratio = 0;
  double volume = 0;              ///< [m^3], curved elements integrated
  std::int64_t straightened = 0;  ///< elements whose curved nodes had to be pulled back to the
                                  ///< chord to keep the Jacobian positive
  /// How far the mesh is from the surface that it was made of; not a number where there was none.
  double volume_error = std::numeric_limits<double>::quiet_NaN();  ///< relative, with its sign
  /// Part of the volume that the elements lacked before their boundary was moved to make up for it.
  double volume_added = std::numeric_limits<double>::quiet_NaN();
  double area_error = std::numeric_limits<double>::quiet_NaN();  ///< relative, with its sign
  double hausdorff = std::numeric_limits<double>::quiet_NaN();   ///< of both boundaries, by
                                                                 ///< samples [m]
};
MeshQuality measure_quality(const TetMesh& mesh);
/// Whether elements keep to the surface of a body within a fiftieth of its longest side and half of
/// its mean wall [m], and within a fiftieth of its area; also where there was no surface.
bool follows_surface(const MeshQuality& quality, double longest, double wall);

/// Mean thickness, 2 V / A, with the boundary's area taken from its corners [m].
double mean_thickness(const TetMesh& mesh);

/// Component of every node, numbered from 0 in the order of first nodes; nodes belong together when
/// an element holds both. -1 for a node that no element uses.
std::vector<std::int32_t> node_components(const TetMesh& mesh);
/// Components joined by shared faces or nodes; rigid modes come six for each.
int count_components(const TetMesh& mesh);

}  // namespace carillon::solvers::mesh
