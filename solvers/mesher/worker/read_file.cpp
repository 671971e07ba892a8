#include "solvers/mesher/worker/read_file.hpp"

#include <fmt/core.h>

#include <cmath>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "solvers/mesh/imported/import_file.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "solvers/mesh/shape_signature.hpp"
#include "solvers/mesh/weld.hpp"

namespace carillon::solvers::mesher {
namespace {

using nlohmann::json;
namespace readers = mesh::readers;
namespace imported = mesh::imported;

void scale(std::vector<Vec3>& points, double factor) {
  if (factor == 1) return;
  for (Vec3& p : points) p *= factor;
}

mesh::SurfaceMesh given_surface(const mesh::MeshFile& file) {
  mesh::SurfaceMesh surface = file.surface;
  for (const mesh::Triangle& t : surface.triangles)
    for (const std::int32_t v : t)
      if (!surface.vertices[static_cast<std::size_t>(v)].allFinite())
        throw core::InputError(fmt::format("{}: vertex {} is not finite", file.path, v));
  mesh::drop_unreferenced(surface);
  return surface;
}

/// A file of one surface is one node without a name.
imported::ImportedFile read_nodes(const mesh::MeshFile& file) {
  if (!file.surface.triangles.empty()) return {1, {{"", given_surface(file), {}}}};
  if (readers::has_nodes(file.path)) return imported::import_file(file.path);
  if (!file.node.empty()) {
    throw core::InputError(
        fmt::format("{}: the file has no nodes with names", file.path),
        "leave out node: glTF, DAE, FBX, 3MF, X3D, STEP and IGES files have some");
  }
  return {1, {{"", readers::read_surface(file.path), {}}}};
}

mesh::TetMesh read_tetrahedra(const std::string& path) {
  if (!readers::is_old_msh(path)) return readers::read_msh(path);
  const core::TemporaryFolder folder;
  const std::string modern = (folder / "modern.msh").string();
  imported::modernise_msh(path, modern);
  try {
    return readers::read_msh(modern);
  } catch (const core::InputError& error) {
    std::string message = error.message();
    if (const auto at = message.find(modern); at != std::string::npos)
      message.replace(at, modern.size(), path);
    throw core::InputError(message, error.hint());
  }
}

json describe(const mesh::SurfaceMesh& surface, const std::string& name) {
  const mesh::Box box = mesh::bounding_box(surface.vertices);
  return {{"name", name},
          {"signature", mesh::shape_signature(surface)},
          {"low", {box.low.x(), box.low.y(), box.low.z()}},
          {"high", {box.high.x(), box.high.y(), box.high.z()}},
          {"area", mesh::area(surface)},
          {"volume", std::abs(mesh::signed_volume(surface))},
          {"triangles", surface.triangles.size()}};
}

json describe(const std::string& path) {
  mesh::MeshFile file;
  file.path = path;
  if (readers::gives_tetrahedra(file))
    return {{"unit", 1}, {"whole", describe(boundary_surface(read_tetrahedra(path)), "")}};
  const imported::ImportedFile read = read_nodes(file);
  json nodes = json::array();
  if (readers::has_nodes(path))
    for (const auto& node : read.nodes) nodes.push_back(describe(node.surface, node.name));
  return {{"unit", read.unit},
          {"whole", describe(imported::node_surface(read, path, ""), "")},
          {"nodes", nodes}};
}

}  // namespace

mesh::SurfaceMesh boundary_surface(const mesh::TetMesh& mesh) {
  mesh::SurfaceMesh surface;
  std::vector<std::int32_t> number(mesh.nodes.size(), -1);
  const auto per_face = static_cast<std::size_t>(elements::nodes_per_face(mesh.order));
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    mesh::Triangle t;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto node = static_cast<std::size_t>(mesh.faces[f * per_face + i]);
      if (number[node] < 0) {
        number[node] = static_cast<std::int32_t>(surface.vertices.size());
        surface.vertices.push_back(mesh.nodes[node]);
      }
      t[i] = number[node];
    }
    surface.triangles.push_back(t);
  }
  return surface;
}

FileSurface scaled_surface(const mesh::MeshFile& file) {
  const imported::ImportedFile read = read_nodes(file);
  FileSurface scaled{imported::node_surface(read, file.path, file.node), {}};
  if (file.node.empty() && read.nodes.size() > 1)
    for (const auto& node : read.nodes) scaled.joined.push_back(node.name);
  scale(scaled.surface.vertices,
        readers::scale_to_metres(mesh::bounding_box(scaled.surface.vertices), file, read.unit));
  return scaled;
}

mesh::TetMesh scaled_tetrahedra(const mesh::MeshFile& file) {
  mesh::TetMesh mesh = read_tetrahedra(file.path);
  scale(mesh.nodes, readers::scale_to_metres(mesh::bounding_box(mesh.nodes), file));
  return mesh;
}

json describe_files(const std::vector<std::string>& paths) {
  json all = json::array();
  for (const std::string& path : paths) {
    try {
      all.push_back(describe(path));
    } catch (const std::exception& error) {
      const auto* own = dynamic_cast<const core::Error*>(&error);
      all.push_back({{"error", own ? own->message() : error.what()}});
    }
  }
  return all;
}

std::vector<Vec3> colours_of(const mesh::MeshFile& file, std::span<const Vec3> points) {
  const imported::ImportedFile read = imported::import_file(file.path, true);
  const imported::Paint paint = imported::node_paint(read, file.node);
  if (!paint.shows()) return {};
  mesh::MeshFile any = file;
  any.any_size = true;
  mesh::SurfaceMesh surface = imported::node_surface(read, file.path, file.node);
  scale(surface.vertices,
        readers::scale_to_metres(mesh::bounding_box(surface.vertices), any, read.unit));
  return imported::colours_at(surface, paint, points);
}

}  // namespace carillon::solvers::mesher
