#include "dataset/plan/expected_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/error.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "solvers/pitch/expected_costs.hpp"

namespace carillon::dataset::plan {

namespace {

/// Closed or open triangles; those of tetrahedra count by the size of their file below.
solvers::mesh::ShapeExtent of_file(const FileSurface& surface,
                                   const solvers::mesh::MeshFile& file) {
  const double scale = solvers::mesh::readers::scale_to_metres(surface.bounds, file, surface.unit);
  const double area = surface.area * scale * scale;
  solvers::mesh::ShapeExtent object;
  object.longest_side = surface.bounds.longest_side() * scale;
  object.volume = surface.volume * std::pow(scale, 3);
  if (file.thickness > 0) object.volume = area / 2 * file.thickness;
  object.volume = std::max(object.volume, 1e-4 * area * object.longest_side);
  object.thickness = file.thickness > 0 ? file.thickness : 2 * object.volume / area;
  return object;
}

/// An object of which nothing is known: a box as wide as half its length, a twentieth as thick.
solvers::mesh::ShapeExtent middling(double length) {
  return {std::pow(length, 3) / 40, length / 23, length};
}

}  // namespace

ExpectedObject expected_object(const Shape& shape) {
  const solvers::mesh::MeshRequest& request = shape.request;
  const bool file = !shape.path.empty();
  ExpectedObject object;
  object.extent = middling(request.file.length > 0 ? request.file.length : 0.1);
  if (file && solvers::mesh::readers::mesh_extension(shape.path) == ".msh") {
    std::error_code error;
    const auto bytes = std::filesystem::file_size(shape.path, error);
    object.mesh = solvers::pitch::expected_mesh_of_file(error ? 200e3 : static_cast<double>(bytes),
                                                        object.extent, request.options.order);
    return object;
  }
  std::optional<double> curve_cells;
  try {
    if (!file) {
      object.extent = solvers::families::extent_of(request.shape);
      curve_cells = solvers::families::find_family(request.shape.family).curve_cells;
    }
    // Triangles without area bound nothing.
    if (shape.surface && shape.surface->area > 0)
      object.extent = of_file(*shape.surface, request.file);
  } catch (const core::Error&) {
    // What is wrong is for the task to say.
  }
  if (!file && !curve_cells) curve_cells = 0;
  object.mesh = solvers::pitch::expected_mesh(object.extent, request.options, curve_cells);
  return object;
}

}  // namespace carillon::dataset::plan
