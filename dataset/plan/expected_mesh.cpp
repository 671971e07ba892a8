#include "dataset/plan/expected_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/error.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"

namespace carillon::dataset::plan {

namespace {

/// @param share  of the box that the object fills
ExpectedObject box(double x, double y, double z, double fraction = 1) {
  return {fraction * x * y * z, x * y * z / (x * y + y * z + z * x), std::max({x, y, z}), {}};
}

constexpr double ellipsoid = std::numbers::pi / 6;

ExpectedObject generated(const solvers::mesh::GeneratedShape& shape) {
  const auto at = [&](const char* name) { return shape.parameters.at(name); };
  if (shape.family == "tile") return box(at("length"), at("width"), at("thickness"));
  if (shape.family == "bar" || shape.family == "block") {
    return box(at("length"), at("width"), at("height"));
  }
  if (shape.family == "wrench") {
    // Two thirds of the way is handle, a third head.
    const double width = (2 * at("handle_width") + 1.3 * at("head_radius")) / 3;
    return box(at("length"), width, at("thickness"));
  }
  // Volumes of ellipsoids beside those of their boxes.
  if (shape.family == "pebble") return box(at("length"), at("width"), at("height"), ellipsoid);
  if (shape.family == "box" || shape.family == "bauble") {
    const double fraction = shape.family == "box" ? 1 : ellipsoid, wall = at("wall");
    ExpectedObject object = box(at("length"), at("width"), at("height"), fraction);
    object.volume -=
        fraction * (at("length") - 2 * wall) * (at("width") - 2 * wall) * (at("height") - 2 * wall);
    object.thickness = wall;
    return object;
  }
  const solvers::families::Family& family = solvers::families::find_family(shape.family);
  const solvers::mesh::MeridianSize size = solvers::mesh::measure(family.meridian(shape));
  return {size.volume, 2 * size.volume / size.surface, size.longest_side(), {}};
}

/// Closed or open triangles; those of tetrahedra count by the size of their file below.
ExpectedObject of_file(const FileSurface& surface, const solvers::mesh::MeshFile& file) {
  const double scale = solvers::mesh::readers::scale_to_metres(surface.bounds, file);
  const double area = surface.area * scale * scale;
  ExpectedObject object;
  object.longest_side = surface.bounds.longest_side() * scale;
  object.volume = surface.volume * std::pow(scale, 3);
  if (file.thickness > 0) object.volume = area / 2 * file.thickness;
  object.volume = std::max(object.volume, 1e-4 * area * object.longest_side);
  object.thickness = file.thickness > 0 ? file.thickness : 2 * object.volume / area;
  return object;
}

/// An object of which nothing is known.
ExpectedObject middling(double length) {
  return box(length, length / 2, length / 20);
}

/// Least and most tetrahedra where the size is left to the mesher, order by order: of generated
/// objects as solvers/families/sizing.cpp bounds them, of files a few times as many.
std::array<double, 2> automatic_tetrahedra(int order, bool file) {
  constexpr std::array<std::array<double, 2>, 4> generated{
      {{4000, 20000}, {2400, 5000}, {900, 1700}, {300, 700}}};
  std::array<double, 2> bounds = generated[static_cast<std::size_t>(std::clamp(order, 1, 4) - 1)];
  if (file) bounds = {2 * bounds[0], 3 * bounds[1]};
  return bounds;
}

/// Longest edge that resolves bending waves of 20 kHz at a wave speed of 5 km/s, as the mesher's.
double automatic_cell(int order, double thickness) {
  constexpr std::array<double, 4> cells_per_radian{0.35, 0.7, 1.4, 2.4};
  constexpr double omega = 2 * std::numbers::pi * 20000, speed = 5000;
  return cells_per_radian[static_cast<std::size_t>(std::clamp(order, 1, 4) - 1)] /
         std::sqrt(std::sqrt(12.0) * omega / (speed * thickness));
}

/// Cells that a family needs in one layer to follow its curves, however large they may be; counted
/// on meshes of instances in the middle of the families' ranges.
double columns_of_curves(const std::string& family) {
  if (family == "plate") return 300;
  if (family == "bowl") return 200;
  if (family == "cup" || family == "vase" || family == "bell") return 150;
  if (family == "tube") return 110;
  return family == "ring" || family == "disc" || family == "turned" ? 60 : 0;
}

/// Cells of a wall, or of a solid, each cut into six tetrahedra.
solvers::pitch::MeshSize count_mesh(const ExpectedObject& object, const Shape& shape, bool file) {
  const solvers::mesh::MeshOptions& options = shape.request.options;
  const double midsurface = object.volume / object.thickness;
  const bool given = options.element_size > 0;
  double cell = 0;
  if (given) {
    // As the families choose: an edge is a cell's diagonal.
    const double edge = options.element_size, t = object.thickness;
    cell = t >= edge / std::numbers::sqrt3 ? edge / std::numbers::sqrt3
                                           : std::sqrt((edge * edge - t * t) / 2);
  } else {
    cell = automatic_cell(options.order, object.thickness);
  }
  const auto layers_of = [&](double size) {
    return given ? std::max(1.0, std::ceil(object.thickness / size))
                 : std::max(1.0, std::round(object.thickness / (1.3 * size)));
  };
  double layers = layers_of(cell);
  double columns = std::max(1.0, midsurface / (cell * cell));
  if (given) {
    columns += columns_of_curves(shape.request.shape.family);
  } else {
    const auto [least, most] = automatic_tetrahedra(options.order, file);
    const double wanted = std::clamp(6 * columns * layers, least, most);
    columns *= wanted / (6 * columns * layers);
  }
  columns = std::min(columns, static_cast<double>(options.max_elements) / (6 * layers));
  solvers::pitch::MeshSize mesh;
  mesh.order = options.order;
  mesh.element_size = std::sqrt(2 * midsurface / columns);
  mesh.thickness = object.thickness;
  mesh.elements = 6 * columns * layers;
  mesh.vertices = columns * (layers + 1);
  mesh.faces = 2 * mesh.elements + 2 * columns;
  mesh.edges = std::max(0.0, mesh.vertices + mesh.faces - mesh.elements - 1);
  return mesh;
}

/// Tetrahedra that stand in a file, taken as they are: about 40 bytes each with their fraction of
/// the nodes, as text or binary.
void count_tetrahedra(const Shape& shape, ExpectedObject& object) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(shape.path, error);
  const double elements = error ? 5000 : std::max(10.0, static_cast<double>(bytes) / 40);
  object.mesh.order = shape.request.options.order;
  object.mesh.thickness = object.thickness;
  object.mesh.elements = elements;
  object.mesh.vertices = elements / 4;
  object.mesh.faces = 2.2 * elements;
  object.mesh.edges = object.mesh.vertices + object.mesh.faces - elements;
  object.mesh.element_size = 2 * std::cbrt(6 * object.volume / elements);
}

}  // namespace

double longest_side(const solvers::mesh::GeneratedShape& shape) {
  return generated(shape).longest_side;
}

void scale_to(solvers::mesh::GeneratedShape& shape, double length) {
  const double factor = length / longest_side(shape);
  for (auto& [name, value] : shape.parameters) value *= factor;
  for (auto& point : shape.profile) {
    for (double& value : point) value *= factor;
  }
}

ExpectedObject expected_object(const Shape& shape) {
  const bool file = !shape.path.empty();
  const double length = shape.request.file.length > 0 ? shape.request.file.length : 0.1;
  ExpectedObject object = middling(length);
  if (file && solvers::mesh::readers::mesh_extension(shape.path) == ".msh") {
    count_tetrahedra(shape, object);
    return object;
  }
  try {
    if (!file) object = generated(shape.request.shape);
    if (shape.surface) object = of_file(*shape.surface, shape.request.file);
  } catch (const core::Error&) {
    // What is wrong is for the task to say.
  }
  object.mesh = count_mesh(object, shape, file);
  return object;
}

}  // namespace carillon::dataset::plan
