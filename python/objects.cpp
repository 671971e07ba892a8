#include "python/objects.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/units.hpp"
#include "scene/family_json.hpp"
#include "scene/material_json.hpp"
#include "scene/modes_config.hpp"
#include "scene/object.hpp"
#include "scene/solved_object_json.hpp"
#include "scene/sounding_gltf.hpp"
#include "scene/strikes.hpp"
#include "scene/tuned_object.hpp"
#include "solvers/libraries/one_thread.hpp"
#include "solvers/modes/modes_file.hpp"
#include "synth/damping/damping.hpp"

namespace carillon::python {

namespace {

using core::InputError;
using nlohmann::json;

/// A shape that has not been solved, and the name that messages call it.
struct Shape {
  std::string name;
  scene::Object object;
  solvers::mesh::SurfaceMesh surface{};  ///< of one that came as arrays
};

/// Takes what may be said of an object beside its shape: `length`, `thickness` [m], `unit`, `node`,
/// `any_size`, `first_axis` and `second_axis`.
void apply(const std::string& settings, scene::Object& object) {
  const json given = json::parse(settings);
  object.file.length = given.value("length", 0.0);
  object.file.thickness = given.value("thickness", 0.0);
  object.file.any_size = given.value("any_size", false);
  const std::string unit = given.value("unit", "");
  if (object.file.length < 0 || object.file.thickness < 0) {
    throw InputError("length and thickness must not be negative", "leave out what is not known");
  }
  const bool generated = !object.family.empty();
  if (generated && (!unit.empty() || object.file.thickness > 0)) {
    throw InputError(fmt::format("{} is generated: unit and thickness do not apply", object.family),
                     "they are of files and arrays");
  }
  if (!unit.empty()) object.file.unit = core::parse_unit_of_length(unit);
  if (const std::string node = given.value("node", ""); !node.empty()) {
    if (generated) throw InputError(fmt::format("{} is generated: it has no nodes", object.family));
    object.nodes.names = {node};
  }
  const auto axis = [&](const char* name) -> std::optional<Vec3> {
    if (!given.contains(name)) return std::nullopt;
    const auto values = given.at(name).get<std::array<double, 3>>();
    return Vec3(values[0], values[1], values[2]);
  };
  object.material_axes = scene::material_axes(axis("first_axis"), axis("second_axis"));
}

Shape shape_from_text(const std::string& text, const std::string& settings) {
  const json given = json::parse(settings);
  const scene::ProfileOptions profile{given.value("profile_axis", ""),
                                      given.value("profile_id", ""), given.value("length", 0.0)};
  Shape shape{text, scene::parse_object(text, "", profile)};
  apply(settings, shape.object);
  return shape;
}

Shape turned_shape(const Triples& profile, const std::string& settings) {
  if (profile.ndim() != 2 || profile.shape(1) != 2 || profile.shape(0) < 3) {
    throw InputError(
        "a profile is an array of at least three points (radius, height), [n, 2] in m");
  }
  Shape shape{"turned", {}};
  shape.object.name = shape.object.family = "turned";
  const auto points = profile.unchecked<2>();
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    if (!std::isfinite(points(i, 0)) || !std::isfinite(points(i, 1))) {
      throw InputError(fmt::format("profile: row {} is not finite", i));
    }
    shape.object.profile.push_back({points(i, 0), points(i, 1)});
  }
  apply(settings, shape.object);
  return shape;
}

Shape shape_from_arrays(
    const Triples& vertices,
    const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>& faces,
    const std::string& name, const std::string& settings) {
  Shape shape{name, {}};
  shape.object.name = name;
  shape.object.pattern = name;
  apply(settings, shape.object);
  shape.surface.vertices = vectors_of(vertices, "vertices");
  if (faces.ndim() != 2 || faces.shape(1) != 3 || faces.shape(0) == 0) {
    throw InputError("faces are triangles: an array of indices, [count, 3]");
  }
  const auto count = static_cast<std::int64_t>(shape.surface.vertices.size());
  const auto rows = faces.unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    solvers::mesh::Triangle triangle{};
    for (py::ssize_t k = 0; k < 3; ++k) {
      const std::int64_t vertex = rows(i, k);
      if (vertex < 0 || vertex >= count) {
        throw InputError(fmt::format("face {} names vertex {} of {}", i, vertex, count),
                         "vertices are counted from 0");
      }
      triangle[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(vertex);
    }
    shape.surface.triangles.push_back(triangle);
  }
  return shape;
}

solvers::mesh::MeshRequest mesh_request(const Shape& shape) {
  solvers::mesh::MeshRequest request = scene::mesh_request(shape.object);
  if (!shape.surface.triangles.empty()) request.file.surface = shape.surface;
  return request;
}

/// Materials by region: a text for all of it, or an object of texts.
scene::RegionMaterials materials_of(const scene::Object& object, const json& materials) {
  if (materials.is_string()) return scene::region_materials(object, materials.get<std::string>());
  scene::Object with_groups = object;
  for (const auto& [group, material] : materials.items()) with_groups.groups[group] = material;
  return scene::region_materials(with_groups, "");
}

/// @param tune  pitch that a mode is brought to [Hz]; 0: the shape has its size
SolvedPointer solve(const Shape& shape, const std::string& materials, const std::string& settings,
                    double tune, int tune_mode, const std::string& cache) {
  if (tune > 0 && shape.object.file.length > 0) {
    throw InputError("the object's length and tune both say how large it is", "keep one of them");
  }
  core::ConfigNode root = core::ConfigNode::parse(settings, "modes()");
  scene::ModesConfig config;
  // The band's top is a setting of its own here, whatever sounds will be made.
  constexpr double any_rate = 1e6;
  scene::read_modes(root.child("modes"), any_rate, config);
  scene::read_solver(root.child("solver"), config);
  root.finish();
  scene::ObjectRequest request = scene::object_request(
      config, mesh_request(shape), materials_of(shape.object, json::parse(materials)));
  start_solver();
  return interruptible([request = std::move(request), name = shape.name, tune, tune_mode,
                        cache](const Waiting& waiting) mutable -> SolvedPointer {
    const solvers::libraries::OneThread alone;
    request.solve.time = waiting.limit("the solve");
    auto solved = std::make_shared<Solved>();
    solved->name = name;
    solved->cache = cache;
    solved->object = tune > 0 ? scene::solve_tuned(request, {tune, tune_mode}, MPI_COMM_SELF, cache)
                              : scene::solve_object(request, MPI_COMM_SELF, cache);
    return solved;
  });
}

synth::damping::DecayRates decay_rates(const Solved& solved) {
  return synth::damping::clamped_decay_rates(solved.object.modes,
                                             scene::damping_of(solved.object.materials));
}

/// @param group      of the file: "", or a set of a build's file
/// @param materials  one for each region, or one for all
SolvedPointer load_modes(const std::string& path, const std::string& group, const std::string& name,
                         const std::vector<std::string>& materials, const std::string& cache) {
  auto solved = std::make_shared<Solved>();
  solved->name = name;
  solved->cache = cache;
  solved->is_meshed = false;
  const core::Hdf5Group file = core::Hdf5Group::open_file(path);
  solved->object.modes = group.empty() ? solvers::modes::read_modes(file)
                                       : solvers::modes::read_modes(file.open_group(group));
  const auto regions = static_cast<std::size_t>(
      std::max<Eigen::Index>(1, solved->object.modes.kinetic_fraction.cols()));
  if (materials.size() != 1 && materials.size() != regions) {
    throw InputError(fmt::format("{} has {} regions, not {}", path, regions, materials.size()),
                     "give one material, or one for each region");
  }
  for (std::size_t i = 0; i < regions; ++i) {
    solved->object.materials.push_back(
        synth::material::parse_material(materials[materials.size() == 1 ? 0 : i]));
  }
  return solved;
}

/// @param node  "": the only one with a modal model
SolvedPointer load_sounding_gltf(const std::string& path, const std::string& node,
                                 const std::string& cache) {
  auto solved = std::make_shared<Solved>();
  solved->name = path;
  solved->cache = cache;
  solved->is_meshed = false;
  solved->object = scene::read_sounding_gltf(path, node);
  return solved;
}

/// What `carillon modes --json` says, of what is known.
std::string description_of(const Solved& solved) {
  json document = scene::to_json(solved.object, decay_rates(solved));
  if (!solved.is_meshed) {
    for (const char* unknown : {"mesh", "repair", "solver", "timing"}) document.erase(unknown);
  }
  return document.dump();
}

SolvedPointer in_material(const Solved& solved, const std::string& text, double size) {
  auto changed = std::make_shared<Solved>(solved);
  changed->object = scene::in_material(solved.object, synth::material::parse_material(text), size);
  changed->is_meshed = solved.is_meshed && size == 1;
  return changed;
}

/// One number of each mode.
template <class Number>
py::array_t<double> each_mode(const Solved& solved, const Number& number) {
  std::vector<double> values(solved.object.modes.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = number(i);
  return array_of(std::move(values));
}

py::array_t<float> shapes_of(const Solved& solved) {
  const auto rows = solved.object.modes.shapes.at_nodes();
  return array_of(std::vector<float>(rows.data(), rows.data() + rows.size()),
                  {rows.rows(), rows.cols() / 3, 3});
}

py::array_t<double> nodes_of(const Solved& solved) {
  std::vector<double> values;
  for (const Vec3& node : solved.object.modes.surface.nodes) {
    values.insert(values.end(), node.begin(), node.end());
  }
  const auto count = static_cast<py::ssize_t>(solved.object.modes.surface.nodes.size());
  return array_of(std::move(values), {count, 3});
}

py::array_t<std::int32_t> triangles_of(const Solved& solved) {
  std::vector<std::int32_t> values;
  const solvers::mesh::SurfaceMesh flat = solvers::modes::flatten(solved.object.modes.surface);
  for (const auto& triangle : flat.triangles) {
    values.insert(values.end(), triangle.begin(), triangle.end());
  }
  return array_of(std::move(values), {static_cast<py::ssize_t>(flat.triangles.size()), 3});
}

/// A text with its unit as a number.
/// @param name  of the argument, for messages
double quantity(const std::string& text, const std::string& dimension, const std::string& name) {
  using core::Dimension;
  static const std::map<std::string, Dimension> dimensions = {
      {"length", Dimension::length},       {"time", Dimension::time},
      {"frequency", Dimension::frequency}, {"pressure", Dimension::pressure},
      {"density", Dimension::density},     {"level", Dimension::level},
      {"impulse", Dimension::impulse},     {"none", Dimension::none}};
  try {
    return core::parse_quantity(text, dimensions.at(dimension));
  } catch (const core::Error& error) {
    throw InputError(fmt::format("{}: {}", name, error.message()), error.hint());
  }
}

}  // namespace

std::vector<Vec3> vectors_of(const Triples& array, const std::string& what) {
  if (array.ndim() != 2 || array.shape(1) != 3) {
    throw InputError(fmt::format("{} must be an array [count, 3]", what));
  }
  std::vector<Vec3> vectors;
  const auto rows = array.unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    vectors.emplace_back(rows(i, 0), rows(i, 1), rows(i, 2));
    if (!vectors.back().allFinite())
      throw InputError(fmt::format("{}: row {} is not finite", what, i));
  }
  return vectors;
}

Vec3 vector_of(const Triples& array, const std::string& what) {
  if (array.ndim() != 1 || array.shape(0) != 3) {
    throw InputError(fmt::format("{} must be three numbers x, y, z", what));
  }
  const Vec3 vector(array.at(0), array.at(1), array.at(2));
  if (!vector.allFinite()) throw InputError(fmt::format("{} is not finite", what));
  return vector;
}

void bind_objects(py::module_& module) {
  py::class_<Shape>(module, "Shape")
      .def_readonly("name", &Shape::name)
      .def_property_readonly("usual_material",
                             [](const Shape& shape) { return scene::usual_material(shape.object); })
      .def("solve", &solve, py::arg("materials"), py::arg("settings"), py::arg("tune"),
           py::arg("tune_mode"), py::arg("cache"));
  module.def("shape_from_text", &shape_from_text);
  module.def("shape_from_arrays", &shape_from_arrays);
  module.def("turned_shape", &turned_shape);

  py::class_<Solved, std::shared_ptr<Solved>>(module, "Solved")
      .def_readonly("name", &Solved::name)
      .def_property_readonly("frequencies",
                             [](const Solved& solved) {
                               return each_mode(solved, [&](std::size_t i) {
                                 return solved.object.modes.frequency(i);
                               });
                             })
      .def_property_readonly(
          "errors", [](const Solved& solved) { return array_of(solved.object.modes.pitch_errors); })
      .def_property_readonly(
          "residuals", [](const Solved& solved) { return array_of(solved.object.modes.residuals); })
      .def_property_readonly(
          "decay_rates", [](const Solved& solved) { return array_of(decay_rates(solved).values); })
      .def_property_readonly("shapes", &shapes_of)
      .def_property_readonly("nodes", &nodes_of)
      .def_property_readonly("triangles", &triangles_of)
      .def_property_readonly("materials",
                             [](const Solved& solved) {
                               json all = json::array();
                               for (const auto& material : solved.object.materials)
                                 all.push_back(scene::to_json(material));
                               return all.dump();
                             })
      .def_property_readonly("mass", [](const Solved& solved) { return solved.object.modes.mass; })
      .def("json", &description_of)
      .def("warnings", [](const Solved& solved) { return solved.object.warnings; })
      .def("save",
           [](const Solved& solved, const std::string& path) {
             core::write_durably(path, [&](const std::filesystem::path& file) {
               solvers::modes::write_modes(core::Hdf5Group::create_file(file), solved.object.modes);
             });
           })
      .def("in_material", &in_material);
  module.def("load_modes", &load_modes);
  module.def("load_sounding_gltf", &load_sounding_gltf);

  module.def("materials", [] {
    json all = json::array();
    for (const auto& material : synth::material::preset_materials())
      all.push_back(scene::to_json(material));
    return all.dump();
  });
  module.def("parse_material", [](const std::string& text) {
    return scene::to_json(synth::material::parse_material(text)).dump();
  });
  module.def("families", [] {
    json all = json::array();
    for (const auto& family : solvers::families::families()) all.push_back(scene::to_json(family));
    return all.dump();
  });
  module.attr("default_impulse") = scene::default_impulse;
  module.attr("default_contact_time") = scene::default_contact_time;
  module.def("quantity", &quantity);
  module.def("default_cache", [] { return core::default_cache_folder().string(); });
}

}  // namespace carillon::python
