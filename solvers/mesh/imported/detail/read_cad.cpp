#include <fmt/core.h>
#include <gmsh.h>

#include <algorithm>
#include <unordered_map>

#include "core/error.hpp"
#include "core/files.hpp"
#include "solvers/mesh/imported/detail/formats.hpp"
#include "solvers/mesh/tetrahedra/delaunay.hpp"

namespace carillon::solvers::mesh::imported {

namespace {

using Entity = std::pair<int, int>;  ///< dimension and tag

/// Open CASCADE hands out millimetres, whatever a file is in.
constexpr double cad_unit = 1e-3;
constexpr double edges_to_a_turn = 40, longest_edge = 0.1;

/// What Gmsh says of a file that it does not read is of use to the one who made the file.
void reading(const std::string& path, const std::function<void()>& calls) {
  try {
    tetrahedra::with_gmsh("reading", calls);
  } catch (const core::SolverError& error) {
    throw core::InputError(fmt::format("{}: {}", path, error.message()),
                           "open it in a CAD program or in Gmsh and save it as STEP (.step)");
  }
}

/// Solids of the file; faces that bound none, as many IGES files hold them, are sewn first.
std::vector<Entity> solids_of(const std::string& path) {
  std::vector<Entity> read, solids;
  gmsh::model::occ::importShapes(path, read, true);
  gmsh::model::occ::synchronize();
  gmsh::model::getEntities(solids, 3);
  if (!solids.empty()) return solids;
  std::vector<Entity> sewn;
  gmsh::model::occ::healShapes(sewn, {}, 1e-8, true, true, true, true, true);
  gmsh::model::occ::synchronize();
  gmsh::model::getEntities(solids, 3);
  return solids;
}

void mesh_faces() {
  double low[3], high[3];
  gmsh::model::getBoundingBox(-1, -1, low[0], low[1], low[2], high[0], high[1], high[2]);
  const double length = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  gmsh::option::setNumber("Mesh.MeshSizeMax", longest_edge * length);
  gmsh::option::setNumber("Mesh.MeshSizeFromCurvature", edges_to_a_turn);
  gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 1);
  gmsh::model::mesh::generate(2);
}

/// Triangles of some faces, turned outward by the solid that they bound.
SurfaceMesh surface_of(const std::vector<Entity>& faces) {
  SurfaceMesh surface;
  std::unordered_map<std::size_t, std::int32_t> number;
  const auto vertex = [&](std::size_t node) {
    const auto [found, is_new] =
        number.emplace(node, static_cast<std::int32_t>(surface.vertices.size()));
    if (is_new) surface.vertices.push_back(tetrahedra::gmsh_node(node));
    return found->second;
  };
  for (const auto& [dimension, tag] : faces) {
    std::vector<std::size_t> elements, corners;
    constexpr int triangle = 2;
    gmsh::model::mesh::getElementsByType(triangle, elements, corners, std::abs(tag));
    for (std::size_t i = 0; i < corners.size(); i += 3) {
      Triangle t = {vertex(corners[i]), vertex(corners[i + 1]), vertex(corners[i + 2])};
      if (tag < 0) std::swap(t[1], t[2]);
      surface.triangles.push_back(t);
    }
  }
  return surface;
}

std::string name_of(const Entity& entity, std::size_t number) {
  std::string name;
  gmsh::model::getEntityName(entity.first, entity.second, name);
  // "Shapes/assembly/part": the part.
  if (const auto slash = name.rfind('/'); slash != std::string::npos) name.erase(0, slash + 1);
  return name.empty() ? fmt::format("solid-{}", number + 1) : name;
}

}  // namespace

ImportedFile read_cad(const std::string& path) {
  core::read_file(path);  // says why, where it cannot be read
  ImportedFile file;
  file.unit = cad_unit;
  const tetrahedra::GmshModel model;
  reading(path, [&] {
    const std::vector<Entity> solids = solids_of(path);
    mesh_faces();
    for (const Entity& solid : solids) {
      std::vector<Entity> faces;
      gmsh::model::getBoundary({solid}, faces, false, true);
      file.nodes.push_back({name_of(solid, file.nodes.size()), surface_of(faces), {}});
    }
    if (!solids.empty()) return;
    std::vector<Entity> faces;
    gmsh::model::getEntities(faces, 2);
    if (!faces.empty()) file.nodes.push_back({"faces", surface_of(faces), {}});
  });
  return file;
}

void modernise_msh(const std::string& path, const std::string& modern) {
  const tetrahedra::GmshModel model;
  reading(path, [&] {
    gmsh::open(path);
    gmsh::option::setNumber("Mesh.MshFileVersion", 4.1);
    gmsh::option::setNumber("Mesh.SaveAll", 1);
    gmsh::write(modern);
  });
}

}  // namespace carillon::solvers::mesh::imported
