#include "eval/accuracy/accuracy_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/config.hpp"
#include "core/error.hpp"
#include "core/folder_name.hpp"
#include "eval/accuracy/detail/study_object.hpp"
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

/// The refinement levels of `levels:`, of the whole study or of one object.
void read_levels(ConfigNode levels, const StudiedObject& otherwise, StudiedObject& object) {
  object.orders = read_orders(levels, otherwise.orders);
  object.size_factors = positive(levels, "element_size_factors", otherwise.size_factors);
}

/// An object whose elements can have any size.
void read_source(ConfigNode& node, const std::string& file_name, const scene::Object& source,
                 StudiedObject& object) {
  object.request = only_mesh(node, source);
  object.any_size = source.file.any_size;
  if (!source.family.empty()) return;
  if (!source.manifest.empty())
    node.fail("manifest", "a study has one object for each entry", "name each file as `mesh:`");
  const std::string& path = source.pattern;
  if (scene::gives_tetrahedra(object.request)) {
    node.fail("mesh", fmt::format("{}: the elements of an MSH file have one size", path),
              "a study meshes at several sizes: write their surface as OBJ, OFF, PLY or STL");
  }
  at_key(node, "mesh", [&] { return solvers::mesh::readers::kind_of(path); });
  object.optional = node.flag("optional", false);
  if (!object.optional && !node.has("stand_in") && !std::filesystem::exists(path)) {
    node.fail("mesh", fmt::format("{}: no such file", path),
              "`optional: true` passes it over, `stand_in:` puts a noisy shape in its place");
  }
  if (!node.has("stand_in")) return;
  ConfigNode stand_in = node.child("stand_in");
  const scene::Object shape = scene::read_shape(stand_in, file_name);
  object.stand_in =
      StandIn{at_key(stand_in, "parameters", [&] { return scene::mesh_request(shape).shape; }),
              stand_in.not_negative("deviation", Dimension::length)};
}

/// Harmonics need an axis.
void check_reference(const ConfigNode& node, const StudiedObject& object) {
  const std::string& family = object.request.shape.family;
  if (!family.empty() && solvers::families::find_family(family).meridian != nullptr) return;
  node.fail(
      family.empty() ? "mesh" : "shape",
      fmt::format("{} is not a body of revolution, which `reference.kind: axisymmetric` needs",
                  family.empty() ? "a file" : family),
      "`automatic` takes tetrahedra for it");
}

StudiedObject read_study_object(ConfigNode& node, const StudiedObject& shared,
                                const std::vector<std::string>& materials,
                                ReferenceSolver reference, const std::string& file_name) {
  const scene::Object source = scene::read_object(node, materials, {}, file_name);
  StudiedObject object = shared;
  read_source(node, file_name, source, object);
  if (reference == ReferenceSolver::axisymmetric) check_reference(node, object);
  object.name =
      source.name.empty() ? std::filesystem::path(source.pattern).stem().string() : source.name;
  object.material_text = only_material(node, source);
  object.material = synth::material::parse_material(object.material_text);
  read_levels(node.child("levels"), shared, object);
  object.reference_factor =
      node.child("reference")
          .positive("element_size_factor", Dimension::none, shared.reference_factor);
  return object;
}

ReferenceSolver read_reference(ConfigNode node, AccuracyConfig& config, double& factor) {
  const std::string kind =
      node.choice("kind", {"automatic", "axisymmetric", "tetrahedra"}, "automatic");
  config.reference_order = static_cast<int>(node.integer("order", 1, 4, 4));
  factor = node.positive("element_size_factor", Dimension::none, 0.5);
  return kind == "axisymmetric" ? ReferenceSolver::axisymmetric
         : kind == "tetrahedra" ? ReferenceSolver::tetrahedra
                                : ReferenceSolver::automatic;
}

}  // namespace

AccuracyConfig read_accuracy_config(const std::string& text, const std::string& file_name,
                                    const std::vector<std::string>& overrides) {
  ConfigNode root = ConfigNode::parse(text, file_name, overrides);
  AccuracyConfig config;
  config.name = core::folder_name(root, file_name);
  const auto materials = root.texts("materials", std::vector<std::string>{"steel"});
  ConfigNode modes = root.child("modes");
  config.band =
      scene::read_band(modes, {.min_frequency = 20, .max_frequency = 200e3, .max_modes = 24});
  config.max_elements = modes.integer("max_elements", 1, 100000000, 200000);
  StudiedObject usual, shared;
  usual.orders = {1, 2, 3, 4};
  usual.size_factors = {1.5, 1, 0.7};
  ConfigNode levels = root.child("levels");
  read_levels(levels, usual, shared);
  config.tolerances = positive(levels, "tolerances", {1e-12});
  config.pitch_targets = positive(root, "pitch_targets", {1, 2, 5, 10, 20});
  for (const double cents : config.pitch_targets) {
    if (cents < solvers::pitch::min_pitch_target || cents > 1e4) {
      root.fail("pitch_targets",
                fmt::format("{} is outside {} to 10000", cents, solvers::pitch::min_pitch_target));
    }
  }
  config.all_ranks = root.flag("all_ranks", false);
  config.cpu_time = root.choice("clock", {"wall", "processor"}, "wall") == "processor";
  ConfigNode repeats = root.child("repeats");
  config.repeat_below = repeats.quantity("below", Dimension::time, 1);
  config.max_runs = static_cast<int>(repeats.integer("max_runs", 1, 100, 3));
  config.reference = read_reference(root.child("reference"), config, shared.reference_factor);
  std::set<std::string> names;
  for (ConfigNode& node : root.children("objects")) {
    config.objects.push_back(
        read_study_object(node, shared, materials, config.reference, file_name));
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
    config.sound = read_sound_study(root.child("sound"), materials, file_name, reread);
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
