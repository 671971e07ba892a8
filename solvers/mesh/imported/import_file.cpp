#include "solvers/mesh/imported/import_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/error.hpp"
#include "core/units.hpp"
#include "solvers/mesh/imported/detail/formats.hpp"
#include "solvers/mesh/readers/file_kind.hpp"

namespace carillon::solvers::mesh::imported {

namespace {

std::vector<std::string> names_of(const ImportedFile& file) {
  std::vector<std::string> names;
  for (const ImportedNode& node : file.nodes) names.push_back(node.name);
  return names;
}

/// Names that stand twice or not at all get a number.
void name_apart(ImportedFile& file) {
  std::set<std::string> taken;
  for (ImportedNode& node : file.nodes) {
    if (node.name.empty()) node.name = "node";
    std::string name = node.name;
    for (int number = 2; !taken.insert(name).second; ++number)
      name = fmt::format("{}-{}", node.name, number);
    node.name = name;
  }
}

}  // namespace

ImportedFile import_file(const std::string& path, bool paint) {
  const bool is_scene = readers::kind_of(path) == readers::FileKind::scene;
  ImportedFile file = is_scene ? read_scene(path, paint) : read_cad(path);
  std::erase_if(file.nodes,
                [](const ImportedNode& node) { return node.surface.triangles.empty(); });
  if (file.nodes.empty()) throw core::InputError(fmt::format("{}: the file has no faces", path));
  for (const ImportedNode& node : file.nodes) {
    for (const Vec3& vertex : node.surface.vertices) {
      if (!vertex.allFinite())
        throw core::InputError(
            fmt::format("{}: a vertex of \"{}\" is not finite", path, node.name));
    }
  }
  name_apart(file);
  return file;
}

SurfaceMesh node_surface(const ImportedFile& file, const std::string& path,
                         const std::string& wanted) {
  SurfaceMesh joined;
  for (const ImportedNode& node : file.nodes) {
    if (!wanted.empty() && node.name != wanted) continue;
    const auto first = static_cast<std::int32_t>(joined.vertices.size());
    joined.vertices.insert(joined.vertices.end(), node.surface.vertices.begin(),
                           node.surface.vertices.end());
    for (const Triangle& t : node.surface.triangles)
      joined.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  if (joined.triangles.empty()) {
    const std::vector<std::string> names = names_of(file);
    const std::string near = core::nearest_name(wanted, names);
    throw core::InputError(fmt::format("{}: no node \"{}\"", path, wanted),
                           near.empty() ? fmt::format("its nodes are {}", fmt::join(names, ", "))
                                        : fmt::format("did you mean \"{}\"?", near));
  }
  return joined;
}

Paint node_paint(const ImportedFile& file, const std::string& wanted) {
  Paint joined;
  for (const ImportedNode& node : file.nodes) {
    if (!wanted.empty() && node.name != wanted) continue;
    const std::size_t first = joined.coats.size();
    joined.coats.insert(joined.coats.end(), node.paint.coats.begin(), node.paint.coats.end());
    for (Paint::Face face : node.paint.faces) {
      face.coat += first;
      joined.faces.push_back(face);
    }
  }
  return joined;
}

}  // namespace carillon::solvers::mesh::imported
