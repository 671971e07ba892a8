#include <map>
#include <optional>
#include <string_view>

#include "core/config.hpp"
#include "synth/damping/damping_text.hpp"
#include "synth/material/detail/material_fields.hpp"

namespace carillon::synth::material {

/// The text of share/carillon/materials.yaml; see carillon_embed() in synth/CMakeLists.txt.
extern const std::string_view materials_yaml;

namespace {

std::map<int, double> read_alphas(core::ConfigNode& node, const std::string& word) {
  std::map<int, double> alphas;
  for (const std::string& key : node.keys()) {
    if (const auto number = damping::alpha_number(key)) {
      alphas[*number] = node.quantity(key, damping::alpha_dimension(word, *number));
    }
  }
  // Asked for in any case, so that a slip of the name is told.
  for (const int number : {1, 2}) {
    const std::string key = damping::parameter_name(static_cast<std::size_t>(number) - 1);
    if (!node.has(key)) node.quantity(key, core::Dimension::none, 0.0);
  }
  return alphas;
}

/// @param node  the mapping that holds the alphas
/// @param key   of the model's name or formula in it
damping::DampingModel read_damping(core::ConfigNode& node, const std::string& key) {
  const std::string word = node.text(key, "");
  const std::map<int, double> alphas = read_alphas(node, word);
  const damping::DampingModel model = core::at_key(
      node, node.has(key) ? key : "", [&] { return damping::make_damping(word, alphas); });
  if (const auto fault = damping::damping_fault(model)) {
    node.fail(node.has(fault->key) ? fault->key : key, fault->message, fault->hint);
  }
  return model;
}

void read_elastic(core::ConfigNode& node, solvers::elements::Elastic& elastic) {
  GivenElastic given;
  for (const ElasticField& field : elastic_fields())
    if (node.has(field.name))
      given.constants[field.name] = node.quantity(field.name, field.dimension);
  if (node.has("stiffness")) {
    given.stiffness =
        stiffness_matrix(node.square_matrix("stiffness", core::Dimension::pressure, 6));
    if (!given.stiffness) node.fail("stiffness", "a stiffness is a symmetric matrix");
  }
  if (const auto fault = make_elastic(given, elastic)) {
    // A constant that is missing is asked for, so that the error names it and its unit.
    for (const ElasticField& field : elastic_fields())
      if (fault->key == field.name && !node.has(field.name))
        node.quantity(field.name, field.dimension);
    node.fail(fault->key, fault->message, fault->hint);
  }
}

Material read_material(core::ConfigNode node, const std::string& name, const std::string& path) {
  Material material;
  material.name = name;
  read_elastic(node, material.elastic);
  if (node.is_mapping("damping")) {
    core::ConfigNode damping = node.child("damping");
    material.damping = read_damping(damping, "model");
  } else {
    material.damping = read_damping(node, "damping");
  }
  material.source = node.text("citation", path);
  if (node.has("group")) material.group = node.choice("group", material_groups());
  if (node.has("appearance")) {
    material.appearance =
        render::looks::read_appearance(node.child("appearance"), appearance_of(material));
  }
  node.finish();
  if (const auto fault = material_fault(material)) {
    node.fail(fault->key, fault->message, fault->hint);
  }
  return material;
}

/// @param path  for messages, and the source of those that name none
std::vector<Material> materials_of(const std::string& text, const std::string& path) {
  core::ConfigNode root = core::ConfigNode::parse(text, path);
  std::vector<Material> materials;
  for (const std::string& name : root.keys()) {
    // Such a name could never be told from a list of numbers.
    if (name.empty() || name.find_first_of("=,") != std::string::npos) {
      root.fail(name, "a material's name must not be empty nor contain \"=\" or \",\"");
    }
    // It is a folder's name in keys, which files of sounds are named by.
    if (name == "." || name == ".." || name.find('/') != std::string::npos) {
      root.fail(name, "a material's name must not contain \"/\" nor be \".\" or \"..\"",
                "it names folders of sound files");
    }
    materials.push_back(read_material(root.child(name), name, path));
  }
  root.finish();
  return materials;
}

}  // namespace

std::vector<Material> read_materials(const std::string& path) {
  return materials_of(core::read_text_file(path), path);
}

const std::vector<Material>& preset_materials() {
  static const std::vector<Material> presets =
      materials_of(std::string(materials_yaml), "share/carillon/materials.yaml");
  return presets;
}

}  // namespace carillon::synth::material
