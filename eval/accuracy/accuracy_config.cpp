#include "eval/accuracy/accuracy_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/config.hpp"
#include "core/error.hpp"
#include "scene/pitch.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"

namespace carillon::eval::accuracy {

using core::at_key;
using core::ConfigNode;
using core::Dimension;

namespace {

std::vector<double> positive(ConfigNode& node, const std::string& key,
                             const std::vector<double>& fallback) {
  const auto values = node.quantities(key, Dimension::none, 0, fallback);
  if (values.empty()) node.fail(key, "no value is named");
  for (const double value : values) {
    if (!(value > 0)) node.fail(key, fmt::format("{} is not positive", value));
  }
  return values;
}

std::vector<int> read_orders(ConfigNode& node, const std::vector<int>& fallback) {
  const auto values = positive(node, "orders", {fallback.begin(), fallback.end()});
  std::vector<int> orders;
  for (const double value : values) {
    const int order = static_cast<int>(value);
    if (order != value || order > 4) node.fail("orders", "elements have order 1 to 4");
    orders.push_back(order);
  }
  return orders;
}

solvers::mesh::GeneratedShape read_shape(ConfigNode& node) {
  solvers::mesh::GeneratedShape shape;
  shape.family = node.text("shape");
  const auto& family = at_key(node, "shape", [&]() -> const solvers::families::Family& {
    return solvers::families::find_family(shape.family);
  });
  if (shape.family == "turned") {
    for (ConfigNode& point : node.children("profile")) {
      shape.profile.push_back({point.quantity("radius", Dimension::length),
                               point.quantity("height", Dimension::length)});
    }
  }
  ConfigNode parameters = node.child("parameters");
  for (const auto& p : family.parameters) {
    shape.parameters[p.name] =
        parameters.quantity(p.name, Dimension::length, 0.5 * (p.low + p.high));
  }
  at_key(node, "parameters", [&] {
    family.check(shape);
    return 0;
  });
  return shape;
}

/// Whether the name ends like a surface that the mesher reads.
bool is_surface(const std::string& path) {
  const std::string ending = solvers::mesh::readers::mesh_extension(path);
  return ending == ".obj" || ending == ".off" || ending == ".ply" || ending == ".stl";
}

void read_file(ConfigNode& node, StudiedObject& object, const std::string& file_name) {
  auto& file = object.request.file;
  file.path = core::path_beside(file_name, node.text("mesh"));
  file.length = node.not_negative("length", Dimension::length, 0);
  if (scene::gives_tetrahedra(object.request)) {
    node.fail("mesh", fmt::format("{}: the elements of an MSH file have one size", file.path),
              "the study meshes at several sizes: write their surface as OBJ, OFF, PLY or STL");
  }
  if (!is_surface(file.path)) {
    node.fail("mesh", fmt::format("{}: surfaces are OBJ, OFF, PLY or STL files", file.path));
  }
  object.optional = node.flag("optional", false);
  if (!object.optional && !node.has("stand_in") && !std::filesystem::exists(file.path)) {
    node.fail("mesh", fmt::format("{}: no such file", file.path),
              "`optional: true` passes it over, `stand_in:` puts a noisy shape in its place");
  }
  if (!node.has("stand_in")) return;
  ConfigNode stand_in = node.child("stand_in");
  object.stand_in =
      StandIn{read_shape(stand_in), stand_in.not_negative("noise", Dimension::length)};
}

/// Harmonics need an axis.
void check_reference(const ConfigNode& node, const StudiedObject& object) {
  const std::string& family = object.request.shape.family;
  if (!family.empty() && solvers::families::find_family(family).meridian != nullptr) return;
  node.fail(
      family.empty() ? "mesh" : "shape",
      fmt::format("{} is not a body of revolution, which `reference.solver: axisymmetric` needs",
                  family.empty() ? "a file" : family),
      "`automatic` takes tetrahedra for it");
}

StudiedObject read_object(ConfigNode& node, const StudiedObject& shared,
                          const std::string& material, ReferenceSolver reference,
                          const std::string& file_name) {
  if (node.has("shape") == node.has("mesh")) {
    node.fail("", "an object is either a `shape:` (a family) or a `mesh:` (a file)");
  }
  StudiedObject object = shared;
  if (node.has("shape")) {
    object.request.shape = read_shape(node);
  } else {
    read_file(node, object, file_name);
  }
  if (reference == ReferenceSolver::axisymmetric) check_reference(node, object);
  object.name = node.text(
      "name", node.has("shape") ? object.request.shape.family
                                : std::filesystem::path(object.request.file.path).stem().string());
  object.material_text = node.text("material", material);
  object.material = at_key(node, "material",
                           [&] { return synth::material::parse_material(object.material_text); });
  object.orders = read_orders(node, shared.orders);
  object.sizes = positive(node, "sizes", shared.sizes);
  object.reference_size = node.positive("reference_size", Dimension::none, shared.reference_size);
  return object;
}

ReferenceSolver read_reference(ConfigNode node, AccuracyConfig& config, double& size) {
  const std::string solver =
      node.choice("solver", {"automatic", "axisymmetric", "tetrahedra"}, "automatic");
  config.reference_order = static_cast<int>(node.integer("order", 1, 4, 4));
  size = node.positive("size", Dimension::none, 0.5);
  return solver == "axisymmetric" ? ReferenceSolver::axisymmetric
         : solver == "tetrahedra" ? ReferenceSolver::tetrahedra
                                  : ReferenceSolver::automatic;
}

}  // namespace

AccuracyConfig read_accuracy_config(const std::string& text, const std::string& file_name,
                                    const std::vector<std::string>& overrides) {
  ConfigNode root = ConfigNode::parse(text, file_name, overrides);
  AccuracyConfig config;
  config.name = root.text("name", std::filesystem::path(file_name).stem().string());
  const std::string material = root.text("material", "steel");
  config.modes = static_cast<int>(root.integer("modes", 1, 10000, 24));
  config.min_frequency = root.not_negative("min_frequency", Dimension::frequency, 20);
  config.max_frequency = root.quantity("max_frequency", Dimension::frequency, 200e3);
  if (!(config.max_frequency > config.min_frequency)) {
    root.fail("max_frequency", "must be above min_frequency");
  }
  StudiedObject shared;
  shared.orders = read_orders(root, {1, 2, 3, 4});
  shared.sizes = positive(root, "sizes", {1.5, 1, 0.7});
  config.tolerances = positive(root, "tolerances", {1e-12});
  config.pitch_cents = positive(root, "pitch_cents", {1, 2, 5, 10, 20});
  for (const double cents : config.pitch_cents) {
    if (cents < solvers::pitch::min_pitch_target || cents > 1e4) {
      root.fail("pitch_cents",
                fmt::format("{} is outside {} to 10000", cents, solvers::pitch::min_pitch_target));
    }
  }
  config.max_elements = root.integer("max_elements", 1, 100000000, 200000);
  config.all_ranks = root.choice("ranks", {"one", "all"}, "one") == "all";
  config.cpu_time = root.choice("clock", {"wall", "processor"}, "wall") == "processor";
  ConfigNode repeats = root.child("repeats");
  config.repeat_below = repeats.quantity("below", Dimension::time, 1);
  config.max_runs = static_cast<int>(repeats.integer("most", 1, 100, 3));
  config.reference = read_reference(root.child("reference"), config, shared.reference_size);
  std::set<std::string> names;
  for (ConfigNode& node : root.children("objects")) {
    config.objects.push_back(read_object(node, shared, material, config.reference, file_name));
    if (!names.insert(config.objects.back().name).second) {
      node.fail("", fmt::format("two objects are named \"{}\"", config.objects.back().name),
                "give one of them another `name:`");
    }
  }
  if (root.has("sound")) {
    const auto reread = [&](const std::vector<std::string>& further) {
      std::vector<std::string> changes = overrides;
      changes.insert(changes.end(), further.begin(), further.end());
      return ConfigNode::parse(text, file_name, changes);
    };
    config.sound = read_sound_study(root.child("sound"), file_name, reread);
  }
  if (root.has("features")) config.features = read_feature_study(root.child("features"));
  if (config.objects.empty() && !config.sound && !config.features) {
    root.fail("objects", "the configuration has neither objects nor `sound:` or `features:`");
  }
  root.finish();
  config.resolved = root.resolved();
  return config;
}

}  // namespace carillon::eval::accuracy
