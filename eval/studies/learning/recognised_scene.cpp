#include "eval/studies/learning/recognised_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/config_text.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "scene/material_json.hpp"
#include "solvers/mesh/shape_source.hpp"
#include "synth/material/material.hpp"

namespace carillon::eval::studies {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

json read_description(const fs::path& dataset) {
  const fs::path path = dataset / "dataset.json";
  if (!fs::exists(path)) {
    throw core::InputError(
        fmt::format("{}, which it was trained with, is no dataset", dataset.string()),
        "objects come from a dataset of carillon build: recordings have none");
  }
  json description = core::read_json(path);
  if (description.is_null()) {
    throw core::InputError(fmt::format("{} is damaged", path.string()),
                           "carillon check tells whether the dataset is whole");
  }
  return description;
}

/// "shape: bar, parameters: {...}" or "mesh: cup.obj".
std::string source_of(const solvers::mesh::MeshRequest& request, const std::string& name) {
  const auto& [family, parameters, profile] = request.shape;
  const solvers::mesh::MeshFile& file = request.file;
  std::string text;
  if (!file.path.empty()) {
    if (!fs::exists(file.path)) {
      throw core::InputError(fmt::format("the mesh of {}, {}, is not there", name, file.path),
                             "run where the dataset was built");
    }
    text = fmt::format("mesh: \"{}\"", fs::absolute(file.path).lexically_normal().string());
    if (!file.node.empty()) text += fmt::format(", nodes: [{}]", core::yaml_text(file.node));
    if (file.unit > 0) text += fmt::format(", unit: {} m", file.unit);
  } else if (!profile.empty()) {
    std::vector<std::string> corners;
    for (const auto& [radius, height] : profile) {
      corners.push_back(fmt::format("{{radius: {}, height: {}}}", radius, height));
    }
    text = fmt::format("shape: {}, profile: [{}]", family, fmt::join(corners, ", "));
  } else {
    std::vector<std::string> values;
    for (const auto& [key, value] : parameters) values.push_back(fmt::format("{}: {}", key, value));
    text = fmt::format("shape: {}, parameters: {{{}}}", family, fmt::join(values, ", "));
  }
  if (file.length > 0) text += fmt::format(", length: {}", file.length);
  return text;
}

/// Puts an item before the others of a list that stands at a place of the text.
std::string with_item(const std::string& text, const YAML::Mark& place, const std::string& item) {
  std::size_t at = 0;
  for (int line = 0; line < place.line; ++line) at = text.find('\n', at) + 1;
  at += static_cast<std::size_t>(place.column);
  std::string longer = text;
  if (text[at] == '[') return longer.insert(at + 1, item + ", ");
  return longer.insert(at, fmt::format("- {}\n{}", item, std::string(place.column, ' ')));
}

YAML::Node list_of(const YAML::Node& root, const std::vector<std::string>& keys,
                   const std::string& file) {
  YAML::Node node = root;
  for (const std::string& key : keys) {
    if (node.IsMap() && node[key]) {
      node.reset(node[key]);
    } else {
      node.reset();
      break;
    }
  }
  if (!node.IsSequence() || node.size() == 0) {
    throw core::InputError(fmt::format("{}: {} is no list of entries", file, fmt::join(keys, ".")),
                           "a scene has objects and motion.bodies: docs/scenes.md");
  }
  return node;
}

YAML::Node parse(const std::string& text, const std::string& file) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw core::InputError(fmt::format("{}: {}", file, error.what()));
  }
}

}  // namespace

RecognisedObject object_of_class(const fs::path& dataset, const std::string& column,
                                 const std::string& name) {
  if (column != "shape" && column != "family") {
    throw core::InputError(fmt::format("a class of the column {} is no object", column),
                           "train a task whose column is shape or family");
  }
  const json description = read_description(dataset);
  for (const json& shape : description.at("shapes")) {
    if (shape.at(column == "shape" ? "id" : "family") != name) continue;
    const std::string id = shape.at("id");
    const json& variant = shape.at("variants").at(0);
    const double size = variant.value("size", 1.0);
    std::string entry = source_of(solvers::mesh::mesh_request_from_json(shape.at("request")), id);
    if (size != 1) entry += fmt::format(", sizes: [{}]", size);
    if (variant.contains("tune_hz")) {
      entry += fmt::format(", tune: {} Hz, tune_mode: {}", variant.at("tune_hz").get<double>(),
                           variant.at("tune_mode").get<int>());
    }
    return {id, entry, ""};
  }
  throw core::InputError(fmt::format("{} has no object of {} {}", dataset.string(), column, name),
                         "the dataset was changed after the training");
}

std::string material_of_class(const fs::path& dataset, const std::string& name) {
  const json description = read_description(dataset);
  for (const json& material : description.at("materials")) {
    if (material.at("name") != name) continue;
    // A dataset's own may have a preset's name.
    for (const synth::material::Material& preset : synth::material::preset_materials()) {
      if (preset.name != name) continue;
      json known = scene::to_json(preset);
      // Datasets of earlier versions do not say it.
      if (!material.contains("group")) known.erase("group");
      if (known == material) return name;
    }
    std::string text = fmt::format("youngs_modulus={},poisson_ratio={},density={}",
                                   material.at("youngs_modulus_pa").get<double>(),
                                   material.at("poisson_ratio").get<double>(),
                                   material.at("density_kg_m3").get<double>());
    if (material.contains("stiffness_pa")) {
      const auto rows = material.at("stiffness_pa").get<std::vector<std::vector<double>>>();
      std::vector<std::string> words;
      for (const auto& row : rows) words.push_back(fmt::format("{}", fmt::join(row, " ")));
      text = fmt::format("stiffness={},density={}", fmt::join(words, " "),
                         material.at("density_kg_m3").get<double>());
    }
    const json& damping = material.at("damping");
    if (damping.contains("expression")) {
      return text + fmt::format(",damping={}", damping.at("expression").get<std::string>());
    }
    if (damping.at("model") != "rayleigh") {
      text += fmt::format(",damping={}", damping.at("model").get<std::string>());
    }
    for (const auto& [key, value] : damping.items()) {
      if (key.starts_with("alpha")) text += fmt::format(",{}={}", key, value.get<double>());
    }
    return text;
  }
  throw core::InputError(fmt::format("{} has no material {}", dataset.string(), name),
                         "the dataset was changed after the training");
}

std::string with_object(const std::string& text, const std::string& file,
                        const RecognisedObject& heard, const Eigen::Vector3d& place) {
  const YAML::Node root = parse(text, file);
  const YAML::Node objects = list_of(root, {"objects"}, file);
  const YAML::Node bodies = list_of(root, {"motion", "bodies"}, file);
  const std::string name = "recognised-" + heard.name;
  for (const YAML::Node& object : objects) {
    if (object["name"] && object["name"].as<std::string>() == name) {
      throw core::InputError(fmt::format("{}: it has an object {} already", file, name),
                             "take it away first, or give another scene");
    }
  }
  const std::string object =
      fmt::format("{{{}, name: {}, materials: [\"{}\"]}}", heard.entry, name, heard.material);
  const std::string moved =
      fmt::format("{{object: {}, at: [{}, {}, {}]}}", name, place.x(), place.y(), place.z());
  // The later one first: what stands before it keeps its place.
  const auto place_of = [](const YAML::Mark& mark) { return std::pair(mark.line, mark.column); };
  const bool objects_first = place_of(objects.Mark()) < place_of(bodies.Mark());
  std::string longer = with_item(text, objects_first ? bodies.Mark() : objects.Mark(),
                                 objects_first ? moved : object);
  longer = with_item(longer, objects_first ? objects.Mark() : bodies.Mark(),
                     objects_first ? object : moved);
  const auto has_one_more = [&] {
    try {
      const YAML::Node whole = YAML::Load(longer);
      return list_of(whole, {"objects"}, file).size() == objects.size() + 1 &&
             list_of(whole, {"motion", "bodies"}, file).size() == bodies.size() + 1;
    } catch (const YAML::Exception&) {
      return false;
    }
  };
  if (!has_one_more()) {
    throw core::InputError(
        fmt::format("{}: its lists cannot be added to as they are written", file),
        "write objects and motion.bodies as lists with a dash for each entry");
  }
  return longer;
}

}  // namespace carillon::eval::studies
