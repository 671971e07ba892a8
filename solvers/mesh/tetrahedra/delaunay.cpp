#include "solvers/mesh/tetrahedra/delaunay.hpp"

#include <fmt/format.h>
#include <gmsh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include "core/error.hpp"
#include "solvers/mesh/flat_elements.hpp"
#include "solvers/mesh/tetrahedra/detail/made_apart.hpp"
#include "solvers/mesh/tetrahedra/detail/mend_slivers.hpp"

namespace carillon::solvers::mesh::tetrahedra {
namespace {

/// A body: its outer component first, then its cavities.
using Body = std::vector<const SurfaceMesh*>;

std::vector<Body> group_bodies(const std::vector<SurfaceMesh>& parts) {
  std::vector<Body> bodies;
  std::vector<double> volumes;
  for (const SurfaceMesh& part : parts) {
    const double volume = signed_volume(part);
    if (!(volume > 0)) continue;
    bodies.push_back({&part});
    volumes.push_back(volume);
  }
  for (const SurfaceMesh& part : parts) {
    const double volume = signed_volume(part);
    if (volume > 0) continue;
    // The tightest body around a cavity owns it.
    std::size_t owner = bodies.size();
    for (std::size_t b = 0; b < bodies.size(); ++b)
      if (volumes[b] > -volume && (owner == bodies.size() || volumes[b] < volumes[owner]) &&
          winding_number(*bodies[b].front(), part.vertices.front()) > 0.5)
        owner = b;
    if (owner == bodies.size())
      throw core::InputError("a component of the surface looks inward and lies in no other",
                             "turn its faces around");
    bodies[owner].push_back(&part);
  }
  if (bodies.empty()) throw core::InputError("the surface has no component that looks outward");
  return bodies;
}

/// Adds a component to Gmsh's model as a discrete surface; node numbers go on from `first`.
int add_surface(const SurfaceMesh& mesh, std::size_t first) {
  const int tag = gmsh::model::addDiscreteEntity(2);
  std::vector<std::size_t> nodes, corners;
  std::vector<double> coordinates;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    nodes.push_back(first + v);
    for (Eigen::Index k = 0; k < 3; ++k) coordinates.push_back(mesh.vertices[v][k]);
  }
  for (const Triangle& t : mesh.triangles)
    for (std::int32_t v : t) corners.push_back(first + static_cast<std::size_t>(v));
  gmsh::model::mesh::addNodes(2, tag, nodes, coordinates);
  gmsh::model::mesh::addElementsByType(tag, 2, {}, corners);
  return tag;
}

/// A way to fill a body.
struct Way {
  int algorithm;  ///< of Gmsh
  bool optimise;
};

void generate_volume(const Way& way) {
  gmsh::option::setNumber("Mesh.Algorithm3D", way.algorithm);
  gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 1);
  gmsh::option::setNumber("Mesh.MeshSizeFromPoints", 0);
  gmsh::option::setNumber("Mesh.MeshOnlyEmpty", 1);  // the surface stays as it is
  gmsh::option::setNumber("Mesh.Optimize", way.optimise ? 1 : 0);
  gmsh::option::setNumber("Mesh.OptimizeThreshold", 0.3);
  gmsh::model::mesh::generate(3);
}

/// The model's tetrahedra, surface nodes first in their order.
TetMesh collect(std::size_t surface_nodes) {
  TetMesh mesh;
  mesh.region_names = {"body"};
  std::vector<std::size_t> tags, elements, corners;
  std::vector<double> coordinates, parametric;
  gmsh::model::mesh::getElementsByType(4, elements, corners);
  gmsh::model::mesh::getNodes(tags, coordinates, parametric);
  if (corners.empty()) throw core::SolverError("Gmsh made no tetrahedra");

  std::map<std::size_t, Vec3> position;  // walked in the order of node numbers
  for (std::size_t i = 0; i < tags.size(); ++i)
    position[tags[i]] = Vec3(coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]);
  std::vector<bool> used(tags.empty() ? 0 : position.rbegin()->first + 1, false);
  for (std::size_t c : corners) used[c] = true;
  std::vector<std::int32_t> number(used.size(), -1);
  for (const auto& [tag, at] : position) {
    if (!used[tag]) {
      if (tag <= surface_nodes) throw core::SolverError("Gmsh lost a vertex of the surface");
      continue;
    }
    number[tag] = static_cast<std::int32_t>(mesh.nodes.size());
    mesh.nodes.push_back(at);
  }
  for (std::size_t c = 0; c < corners.size(); c += 4) {
    std::array<std::int32_t, 4> e;
    for (std::size_t i = 0; i < 4; ++i) e[i] = number[corners[c + i]];
    const auto at = [&](std::size_t i) { return mesh.nodes[static_cast<std::size_t>(e[i])]; };
    if (six_volumes(at(0), at(1), at(2), at(3)) < 0) std::swap(e[2], e[3]);
    mesh.elements.insert(mesh.elements.end(), e.begin(), e.end());
    mesh.regions.push_back(0);
  }
  return mesh;
}

TetMesh fill_body(const Body& body, const Way& way) {
  TetMesh mesh;
  with_gmsh("tetrahedra", [&] {
    GmshModel model;
    std::vector<int> surfaces;
    std::size_t nodes = 0;
    for (const SurfaceMesh* part : body) {
      surfaces.push_back(add_surface(*part, nodes + 1));
      nodes += part->vertices.size();
    }
    gmsh::model::geo::addVolume({gmsh::model::geo::addSurfaceLoop(surfaces)});
    gmsh::model::geo::synchronize();
    generate_volume(way);
    mesh = collect(nodes);
  });
  return mesh;
}

/// A filled body has the volume of its surface, whatever Gmsh says of its success.
void check_volume(const TetMesh& mesh, const Body& body) {
  double wanted = 0, filled = 0;
  for (const SurfaceMesh* part : body) wanted += signed_volume(*part);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) filled += six_volumes(mesh, e) / 6;
  if (!(std::abs(filled - wanted) <= 1e-6 * wanted))
    throw core::SolverError(fmt::format(
        "Gmsh's tetrahedra fill {:.6g} m^3 of a surface that encloses {:.6g} m^3", filled, wanted));
}

/// Ways in the order in which they are tried: HXT's recovery of the boundary is another program,
/// and the optimiser may fail where the mesher does not.
constexpr int delaunay = 1, hxt = 10;
constexpr std::array<Way, 4> ways = {
    {{delaunay, true}, {delaunay, false}, {hxt, true}, {hxt, false}}};
/// [s] The processor time after which a way counts as hanging. It grows with the triangles, lest a
/// large body or a slow machine be taken for one.
unsigned way_seconds(const Body& body) {
  constexpr std::size_t start = 30, triangles_a_second = 500;
  std::size_t triangles = 0;
  for (const SurfaceMesh* part : body) triangles += part->triangles.size();
  return static_cast<unsigned>(start + triangles / triangles_a_second);
}

TetMesh filled(const Body& body) {
  std::string reason;
  for (const Way& way : ways) {
    try {
      TetMesh mesh = made_apart([&] { return fill_body(body, way); }, way_seconds(body));
      check_volume(mesh, body);
      return mesh;
    } catch (const core::SolverError& error) {
      if (reason.empty()) reason = error.message();
    }
  }
  throw core::SolverError("Gmsh cannot fill the surface: " + reason);
}

}  // namespace

GmshModel::GmshModel() {
  gmsh::initialize(0, nullptr, false);
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::option::setNumber("General.NumThreads", 1);
  gmsh::option::setNumber("General.AbortOnError", 2);
  // Gmsh perturbs points by the C library's random numbers: every model begins with the same ones.
  std::srand(1);
  gmsh::model::add("body");
}

GmshModel::~GmshModel() {
  try {
    gmsh::finalize();
  } catch (...) {  // nothing to do: the next model is a new one
  }
}

void with_gmsh(const std::string& what, const std::function<void()>& calls) {
  const auto reason = [] {
    std::string text;
    gmsh::logger::getLastError(text);
    return text.empty() ? std::string("no reason given") : text;
  };
  try {
    calls();
  } catch (const core::Error&) {
    throw;
  } catch (const std::exception& error) {
    throw core::SolverError(fmt::format("Gmsh failed ({}): {}", what, error.what()));
  } catch (const std::string& text) {
    throw core::SolverError(fmt::format("Gmsh failed ({}): {}", what, text));
  } catch (...) {
    throw core::SolverError(fmt::format("Gmsh failed ({}): {}", what, reason()));
  }
}

Vec3 gmsh_node(std::size_t tag) {
  std::vector<double> at, parameters;
#if GMSH_API_VERSION_MAJOR == 4 && GMSH_API_VERSION_MINOR < 9
  gmsh::model::mesh::getNode(tag, at, parameters);
#else
  int dimension = 0, entity = 0;
  gmsh::model::mesh::getNode(tag, at, parameters, dimension, entity);
#endif
  return {at[0], at[1], at[2]};
}

TetMesh fill_with_tetrahedra(const SurfaceMesh& surface) {
  const auto parts = split(surface, edge_components(surface.triangles));
  TetMesh mesh;
  mesh.region_names = {"body"};
  for (const Body& body : group_bodies(parts)) {
    const TetMesh part = filled(body);
    const auto first = static_cast<std::int32_t>(mesh.nodes.size());
    mesh.nodes.insert(mesh.nodes.end(), part.nodes.begin(), part.nodes.end());
    for (const std::int32_t node : part.elements) mesh.elements.push_back(first + node);
    mesh.regions.insert(mesh.regions.end(), part.regions.begin(), part.regions.end());
  }
  mesh.faces = boundary_faces(mesh);
  peel_flat_elements(mesh);
  mend_slivers(mesh);
  return mesh;
}

}  // namespace carillon::solvers::mesh::tetrahedra
