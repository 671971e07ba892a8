#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"
#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh {

/// A body that a formula describes: a family of solvers/families and its parameters [m].
struct GeneratedShape {
  std::string family;                        ///< "bar", "bowl", ... (see families.hpp)
  std::map<std::string, double> parameters;  ///< every parameter of the family
  /// Closed polygon of a turned profile, (radius, height) [m]; only for the family "turned".
  std::vector<std::array<double, 2>> profile;
};

/// A body that a file describes, or triangles in memory as a file would hold them.
struct MeshFile {
  std::string path;     ///< any that readers::kind_of() knows; or the name of `surface`
  std::string node;     ///< of a file that has several: this one alone; "": all, as one body
  SurfaceMesh surface;  ///< where it has triangles: these, in memory, and no file
  double length = 0;    ///< longest side [m] the body is scaled to; 0: as the file says
  /// Of the file's coordinates, where there is no length [m]; 0: what the file says, or else 1 m.
  double unit = 0;
  bool any_size = false;          ///< lets a body outside 1 mm to 10 m pass
  double thickness = 0;           ///< [m] given to open sheets; 0: an open sheet is not a body
  double wrap_tolerance = 0.002;  ///< alpha-wrap offset as a fraction of the box diagonal
};

/// A body's size as far as it is known without a mesh.
struct ShapeExtent {
  double volume = 0;        ///< [m^3]
  double thickness = 0;     ///< 2 volume / area [m]
  double longest_side = 0;  ///< of its box [m]
  int mirror_planes = 0;    ///< that its tetrahedra are symmetric in, beside the next
  bool is_halved = false;   ///< one more where several layers go through its thickness
};

/// How fine the tetrahedra are.
struct MeshOptions {
  int order = 3;            ///< Lagrange order of the nodes, 1 to 4
  double element_size = 0;  ///< largest edge [m]; 0: chosen from thickness and curvature
  std::int64_t max_elements = 200000;
  /// Layers of thin elements at inward edges (grade_to_edges.hpp), 0 to 4; fewer where max_elements
  /// has no room, or where elements would become more than 2.5 times as many, or more by both 6,000
  /// and three tenths. Tetrahedra that a file gives get none.
  int edge_layers = 1;
};

/// A request to the mesher; exactly one of the two sources is used (`family` empty: the file).
struct MeshRequest {
  GeneratedShape shape;
  MeshFile file;
  MeshOptions options;
};

/// What was wrong with a surface and what was done about it.
struct Diagnosis {
  std::int64_t vertices = 0, triangles = 0;
  std::int64_t duplicate_vertices = 0, unreferenced_vertices = 0;
  std::int64_t degenerate_triangles = 0, duplicate_triangles = 0;
  std::int64_t boundary_edges = 0, nonmanifold_edges = 0, nonmanifold_vertices = 0;
  std::int64_t misoriented_edges = 0;   ///< edges whose two faces disagree
  std::int64_t self_intersections = 0;  ///< intersecting triangle pairs, counted up to a limit
  std::int64_t components = 0;          ///< pieces joined by edges
  std::int64_t nested_components = 0, touching_components = 0;
  bool closed = false;             ///< every edge has two faces
  bool clean = false;              ///< watertight, manifold, outward, free of intersections
  double volume = 0, area = 0;     ///< as read [m^3, m^2]
  std::array<double, 3> extent{};  ///< [m]
};

struct RepairReport {
  bool used_as_is = true;
  std::vector<std::string> actions;  ///< in words, in order
  double volume_change = 0;          ///< relative; NaN when the input had no volume
  double area_change = 0;            ///< relative
  /// What would be hollow, or a core in a hollow, if inner surfaces that look outward were not
  /// taken for solid [m^3].
  double swallowed_volume = 0;
  std::int64_t swallowed_surfaces = 0;
  double filled_area = 0;           ///< of the holes that were filled, over the surface's
  std::vector<std::string> joined;  ///< names of the file's nodes, where several became one body
  double wrap_alpha = 0;  ///< gaps narrower than this were closed by a wrap [m]; 0: there is none
};

/// A surface that bounds a body, and what became of the one that was read.
struct RepairedBody {
  SurfaceMesh surface;
  Diagnosis diagnosis;
  RepairReport repair;
};

struct MeshResult {
  TetMesh mesh;
  MeshQuality quality;
  Diagnosis diagnosis;  ///< files only
  RepairReport repair;  ///< files only
};

nlohmann::json to_json(const MeshRequest& request);
nlohmann::json to_json(const Diagnosis& diagnosis);
nlohmann::json to_json(const RepairReport& report);
nlohmann::json to_json(const MeshQuality& quality);
/// Arrays are binary values: these two are meant for CBOR.
nlohmann::json to_json(const RepairedBody& body);
nlohmann::json to_json(const MeshResult& result);
/// The way back. Numbers that are not finite are null in JSON and NaN again here.
/// @throws FileError  fields are missing or of another type, indices point outside
MeshRequest mesh_request_from_json(const nlohmann::json& json);
Diagnosis diagnosis_from_json(const nlohmann::json& json);
RepairedBody repaired_body_from_json(const nlohmann::json& json);
MeshResult mesh_result_from_json(const nlohmann::json& json);

}  // namespace carillon::solvers::mesh
