#include "solvers/mesh/readers/read_mesh.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/files.hpp"
#include "solvers/mesh/readers/detail/read_formats.hpp"
#include "solvers/mesh/readers/detail/text_scanner.hpp"
#include "solvers/mesh/weld.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

/// Sizes that objects are allowed to have, and those that household objects usually have [m].
constexpr double smallest = 1e-3;
constexpr double largest = 10;
constexpr double usual_smallest = 0.01;
constexpr double usual_largest = 2;

struct Unit {
  const char* name;
  const char* symbol;
  double metres;
};
constexpr Unit units[] = {{"millimetres", "mm", 1e-3},
                          {"centimetres", "cm", 1e-2},
                          {"inches", "inch", 0.0254},
                          {"micrometres", "um", 1e-6},
                          {"kilometres", "km", 1e3}};

/// The first unit that makes the object a usual size, else an allowed one, else null.
const Unit* likely_unit(double longest) {
  for (const auto& [low, high] :
       {std::pair(usual_smallest, usual_largest), std::pair(smallest, largest)}) {
    for (const Unit& unit : units) {
      if (longest * unit.metres >= low && longest * unit.metres <= high) return &unit;
    }
  }
  return nullptr;
}

}  // namespace

SurfaceMesh read_surface(const std::string& path) {
  const std::string extension = mesh_extension(path);
  PolygonMesh (*read)(const std::string&, std::string_view) = nullptr;
  if (extension == ".obj") read = read_obj;
  if (extension == ".off") read = read_off;
  if (extension == ".ply") read = read_ply;
  if (extension == ".stl") read = read_stl;
  if (read == nullptr) {
    kind_of(path);  // throws where nobody reads it
    throw core::InputError(fmt::format("{}: has no triangles of its own", path));
  }
  const std::string bytes = without_byte_order_mark(core::read_file(path));
  SurfaceMesh mesh = triangulate(read(path, bytes));
  if (read == read_stl) weld(mesh);
  if (mesh.triangles.empty())
    throw core::InputError(fmt::format("{}: the file has no faces", path));
  return mesh;
}

bool gives_tetrahedra(const MeshFile& file) {
  return file.surface.triangles.empty() && mesh_extension(file.path) == ".msh";
}

double scale_to_metres(const Box& box, const MeshFile& file, double own_unit) {
  const double longest = box.longest_side();
  if (!std::isfinite(longest)) {
    throw core::InputError(fmt::format("{}: the coordinates are too large to measure", file.path));
  }
  if (!(longest > 0)) {
    throw core::InputError(fmt::format("{}: all vertices lie at one point", file.path));
  }
  const double length =
      file.length > 0 ? file.length : (file.unit > 0 ? file.unit : own_unit) * longest;
  if (!file.any_size && (length < smallest || length > largest)) {
    std::string hint = "any_size: true lets it pass";
    const Unit* unit = file.length > 0 ? nullptr : likely_unit(longest);
    if (unit != nullptr) {
      hint = fmt::format("if the file is in {} say unit: {} or length: {:.6g} m; {}", unit->name,
                         unit->symbol, longest * unit->metres, hint);
    } else if (!(file.length > 0)) {
      hint = "length: 0.12 m sets the longest side; " + hint;
    }
    throw core::InputError(
        fmt::format("{}: the longest side is {:.6g} m, outside 1 mm to 10 m", file.path, length),
        hint);
  }
  return length / longest;
}

}  // namespace carillon::solvers::mesh::readers
