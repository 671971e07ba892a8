#include "scene/object.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "core/csv.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "core/what_is.hpp"
#include "solvers/elements/anisotropy.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"

namespace carillon::scene {

using core::at_key;
using core::ConfigNode;
using core::Dimension;
using core::InputError;
using core::path_beside;
using core::Range;

namespace {

/// Points of a profile: columns `radius` and `height`, lengths with or without a unit.
std::vector<std::array<double, 2>> profile_from_csv(const std::string& path) {
  const core::CsvTable table = core::read_csv(path, '#');
  const auto radius = table.column("radius"), height = table.column("height");
  if (!radius || !height)
    throw InputError(fmt::format("{} has no columns radius and height", path),
                     "its first line names them: radius,height");
  std::vector<std::array<double, 2>> points;
  for (const core::CsvRow& row : table.rows) {
    const auto length = [&row](std::size_t column) {
      if (column >= row.cells.size())
        throw InputError(fmt::format("{}: a cell is missing", row.place));
      try {
        return core::parse_quantity(row.cells[column], Dimension::length);
      } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", row.place, error.message()), error.hint());
      }
    };
    points.push_back({length(*radius), length(*height)});
  }
  return points;
}

bool is_profile(const std::string& path) {
  const std::string ending = solvers::mesh::readers::mesh_extension(path);
  return ending == ".svg" || ending == ".csv";
}

std::vector<std::array<double, 2>> profile_from_drawing(const std::string& path,
                                                        const ProfileOptions& options,
                                                        double length) {
  solvers::families::SvgProfileOptions svg;
  // Where the body is scaled as a whole any height will do.
  svg.height = options.height > 0 ? options.height : length;
  svg.axis = options.axis;
  svg.id = options.outline;
  return solvers::families::profile_from_svg(path, svg);
}

void read_profile(ConfigNode& node, const std::string& file_name, Object& object) {
  for (const char* key : {"svg", "csv"}) {
    if (!node.has(key)) continue;
    object.profile_file = path_beside(file_name, node.text(key));
    ProfileOptions options;
    if (std::string_view(key) == "svg") {
      options.height = node.not_negative("svg_height", Dimension::length, 0);
      options.axis = node.text("profile_axis", "");
      options.outline = node.text("profile_id", "");
    }
    const double length = node.not_negative("length", Dimension::length, 0);
    // By its key: the copy that a dataset keeps has another ending.
    at_key(node, key, [&] {
      object.profile = std::string_view(key) == "csv"
                           ? profile_from_csv(object.profile_file)
                           : profile_from_drawing(object.profile_file, options, length);
    });
    return;
  }
  for (ConfigNode& point : node.children("profile")) {
    object.profile.push_back(
        {point.quantity("radius", Dimension::length), point.quantity("height", Dimension::length)});
  }
}

NodeChoice read_nodes(ConfigNode& node) {
  NodeChoice nodes;
  nodes.names = node.texts("nodes", std::vector<std::string>{"joined"});
  if (nodes.names.empty()) node.fail("nodes", "no node is named");
  if (nodes.names.size() == 1 && (nodes.names[0] == "joined" || nodes.names[0] == "each")) {
    nodes.each = nodes.names[0] == "each";
    nodes.names.clear();
  }
  return nodes;
}

Object read_files(ConfigNode& node, const std::string& file_name) {
  Object object;
  if (node.has("modelnet")) {
    const std::string folder = path_beside(file_name, node.text("modelnet"));
    object.pattern = (std::filesystem::path(folder) / "*" / "t[er]*" / "*.off").string();
    object.modelnet = ModelNet{node.texts("classes", std::vector<std::string>{}),
                               static_cast<int>(node.integer("per_class", 0, 1000000, 0))};
  } else if (node.has("manifest")) {
    object.manifest = path_beside(file_name, node.text("manifest"));
    const std::string beside = std::filesystem::path(object.manifest).parent_path().string();
    object.manifest_folder =
        node.has("folder") ? path_beside(file_name, node.text("folder")) : beside;
  } else {
    object.named_by_folder = node.has("glob");
    object.pattern = path_beside(file_name, node.text(node.has("glob") ? "glob" : "mesh"));
  }
  if (!object.modelnet) object.nodes = read_nodes(node);
  if (node.has("unit")) {
    const std::string unit = node.text("unit");
    at_key(node, "unit", [&] { object.file.unit = core::parse_unit_of_length(unit); });
  }
  object.file.thickness = node.not_negative("thickness", Dimension::length, 0);
  object.file.wrap_tolerance = node.quantity("wrap_tolerance", Dimension::none, 0.002);
  if (!(object.file.wrap_tolerance >= 1e-4 && object.file.wrap_tolerance <= 0.05)) {
    node.fail("wrap_tolerance", "must lie between 0.0001 and 0.05 of the box diagonal");
  }
  return object;
}

void read_materials(ConfigNode& node, const std::vector<std::string>& shared,
                    const std::vector<synth::material::Material>& own, Object& object) {
  if (node.is_mapping("materials")) {
    ConfigNode groups = node.child("materials");
    for (const std::string& group : groups.keys()) object.groups[group] = groups.text(group);
    // Anything but an MSH file is meshed here, and is one body.
    solvers::mesh::MeshFile file;
    file.path = object.pattern;
    const bool has_groups =
        object.family.empty() &&
        (!object.manifest.empty() || solvers::mesh::readers::gives_tetrahedra(file));
    const bool is_body = object.groups.size() == 1 && object.groups.contains("body");
    if (!has_groups && !is_body)
      node.fail("materials", "only MSH files have physical groups with materials of their own",
                "name one material for the whole object");
  } else {
    std::vector<std::string> otherwise = shared;
    if (const std::string usual = usual_material(object); otherwise.empty() && !usual.empty())
      otherwise.push_back(usual);
    object.materials = node.texts("materials", otherwise);
    if (object.materials.empty() && object.manifest.empty())
      node.fail("materials", "no material is named");
  }
  at_key(node, "materials", [&] {
    for (const std::string& name : object.materials) synth::material::parse_material(name, own);
    for (const auto& [group, name] : object.groups) synth::material::parse_material(name, own);
  });
}

Object parse_family(const std::string& name, const std::string& values) {
  const solvers::families::Family& family = solvers::families::find_family(name);
  Object object;
  object.name = object.family = family.name;
  std::vector<std::string> names;
  for (const solvers::families::FamilyParameter& parameter : family.parameters) {
    object.parameters[parameter.name] = {parameter.low, parameter.high};
    names.push_back(parameter.name);
  }
  for (const auto& [key, value] : core::parse_assignments(values)) {
    if (!object.parameters.contains(key)) {
      const std::string near = core::nearest_name(key, names);
      throw InputError(fmt::format("{} has no parameter \"{}\"", family.name, key),
                       near.empty() ? fmt::format("it has {}", fmt::join(names, ", "))
                                    : fmt::format("did you mean \"{}\"?", near));
    }
    double length = 0;
    try {
      length = core::parse_quantity(value, Dimension::length);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}:{}: {}", family.name, key, error.message()), error.hint());
    }
    object.parameters[key] = {length, length};
  }
  return object;
}

}  // namespace

Object read_shape(ConfigNode& node, const std::string& file_name) {
  Object object;
  object.family = node.text("shape");
  const solvers::families::Family& family =
      at_key(node, "shape", [&]() -> const solvers::families::Family& {
        return solvers::families::find_family(object.family);
      });
  if (object.family == "turned") read_profile(node, file_name, object);
  ConfigNode parameters = node.child("parameters");
  for (const solvers::families::FamilyParameter& p : family.parameters) {
    object.parameters[p.name] = parameters.range(p.name, Dimension::length, Range{p.low, p.high});
  }
  return object;
}

Object read_object(ConfigNode& node, const std::vector<std::string>& shared_materials,
                   const std::vector<synth::material::Material>& own,
                   const std::string& file_name) {
  if (node.has("shape") + node.has("mesh") + node.has("glob") + node.has("manifest") +
          node.has("modelnet") !=
      1) {
    node.fail("",
              "an object is a `shape:` (a family), a `mesh:` (a file), a `glob:` (files), a "
              "`manifest:` (a table of files) or a `modelnet:` (a folder)");
  }
  Object object = node.has("shape") ? read_shape(node, file_name) : read_files(node, file_name);
  object.name = node.text("name", object.family);
  object.file.length = node.not_negative("length", Dimension::length, 0);
  object.file.any_size = node.flag("any_size", false);
  object.solver = parse_object_solver(
      node.choice("solver", {"automatic", "tetrahedra", "axisymmetric"}, "automatic"));
  read_materials(node, shared_materials, own, object);
  if (node.has("material_axes")) {
    core::ConfigNode axes = node.child("material_axes");
    const auto axis = [&axes](const char* name) {
      const auto v = axes.quantities(name, Dimension::none, 3);
      return Vec3(v[0], v[1], v[2]);
    };
    const Vec3 first = axis("first"), second = axis("second");
    at_key(node, "material_axes", [&] { object.material_axes = material_axes(first, second); });
  }
  return object;
}

Object parse_object(const std::string& shape, const std::string& material,
                    const ProfileOptions& profile) {
  Object object;
  if (is_profile(shape) && std::filesystem::exists(shape)) {
    object.name = std::filesystem::path(shape).stem().string();
    object.family = "turned";
    object.profile_file = shape;
    const std::string ending = solvers::mesh::readers::mesh_extension(shape);
    object.profile =
        ending == ".csv" ? profile_from_csv(shape) : profile_from_drawing(shape, profile, 0);
  } else if (std::filesystem::is_directory(shape)) {
    throw core::InputError(
        fmt::format("{} is {}, and a mesh is wanted", shape, core::what_is(shape).name),
        "name an OBJ, OFF, PLY, STL or MSH file");
  } else if (std::filesystem::exists(shape)) {
    object.pattern = shape;
  } else {
    const auto colon = shape.find(':');
    const std::string family = shape.substr(0, colon);
    if (family.find_first_of("./\\") != std::string::npos) {
      throw core::FileError(fmt::format("{}: no such file", shape));
    }
    object = parse_family(family, colon == std::string::npos ? "" : shape.substr(colon + 1));
  }
  const auto names = [&](const char* field) { return material.find(field) != std::string::npos; };
  if (!names("=") || names("density") || names("youngs_modulus") || names("poisson_ratio")) {
    if (!material.empty()) object.materials = {material};
  } else {
    for (const auto& [group, name] : core::parse_assignments(material)) {
      object.groups[group] = name;
    }
  }
  return object;
}

std::string usual_material(const Object& object) {
  if (object.family.empty()) return "";
  return solvers::families::find_family(object.family).usual_material;
}

solvers::mesh::MeshRequest mesh_request(const Object& object) {
  solvers::mesh::MeshRequest request;
  if (object.family.empty()) {
    request.file = object.file;
    request.file.path = object.pattern;
    if (object.nodes.each || object.nodes.names.size() > 1)
      throw InputError("one object is wanted here, and several nodes are named",
                       "nodes: joined, or the name of one");
    if (!object.nodes.names.empty()) request.file.node = object.nodes.names.front();
    return request;
  }
  request.shape.family = object.family;
  request.shape.profile = object.profile;
  for (const auto& [name, range] : object.parameters) {
    request.shape.parameters[name] = 0.5 * (range.low + range.high);
  }
  solvers::families::find_family(object.family).check(request.shape);
  if (object.file.length > 0) solvers::families::scale_to(request.shape, object.file.length);
  return request;
}

Eigen::Matrix3d material_axes(const std::optional<Vec3>& given_first,
                              const std::optional<Vec3>& given_second) {
  const Vec3 first = given_first.value_or(Vec3::UnitX());
  const bool along_y = first.cross(Vec3::UnitY()).norm() < 1e-3 * first.norm();
  const Vec3 second = given_second.value_or(along_y ? Vec3::UnitZ() : Vec3::UnitY());
  const Vec3 third = first.cross(second);
  if (!first.allFinite() || !second.allFinite() ||
      !(third.norm() > 1e-9 * first.norm() * second.norm()))
    throw core::InputError("the material's axes lie along each other or have no length",
                           "give two directions that differ, such as 1, 0, 0 and 0, 1, 0");
  Eigen::Matrix3d axes;
  axes.col(0) = first.normalized();
  axes.col(2) = third.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

synth::material::Material object_material(const Object& object, const std::string& name,
                                          const std::vector<synth::material::Material>& own) {
  synth::material::Material material = synth::material::parse_material(name, own);
  material.elastic = solvers::elements::rotated(material.elastic, object.material_axes);
  return material;
}

RegionMaterials region_materials(const Object& object, const std::string& material,
                                 const std::vector<synth::material::Material>& own) {
  RegionMaterials materials;
  if (object.groups.empty()) materials[""] = object_material(object, material, own);
  for (const auto& [group, name] : object.groups) {
    materials[group] = object_material(object, name, own);
  }
  return materials;
}

}  // namespace carillon::scene
