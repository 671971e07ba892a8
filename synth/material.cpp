#include "synth/material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "core/config.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace carillon::synth {

namespace {

using core::Dimension;

/// The one list of a material's numbers: name, dimension, where it is kept, whether it may be left
/// out. Everything that reads or lists materials walks it.
struct Field {
  const char* name;
  Dimension dimension;
  double& (*value)(Material&);
  bool required;
};

constexpr std::array<Field, 5> kFields = {{
    {"youngs_modulus", Dimension::pressure,
     [](Material& m) -> double& { return m.elastic.youngs_modulus; }, true},
    {"poisson_ratio", Dimension::none,
     [](Material& m) -> double& { return m.elastic.poisson_ratio; }, true},
    {"density", Dimension::density, [](Material& m) -> double& { return m.elastic.density; }, true},
    // 1/s is not a frequency in Hz, so that alpha1 takes plain numbers only.
    {"alpha1", Dimension::none, [](Material& m) -> double& { return m.damping.alpha1; }, false},
    {"alpha2", Dimension::time, [](Material& m) -> double& { return m.damping.alpha2; }, false},
}};

std::vector<std::string> field_names() {
  std::vector<std::string> names;
  for (const Field& field : kFields) names.emplace_back(field.name);
  return names;
}

struct Violation {
  std::string key;
  std::string message;
  std::string hint;
};

/// The first rule a material breaks.
std::optional<Violation> violation(const Material& material) {
  const auto& [modulus, poisson, density] = material.elastic;
  if (!(modulus > 0) || !std::isfinite(modulus)) {
    return Violation{"youngs_modulus",
                     fmt::format("Young's modulus must be positive, not {} Pa", modulus), ""};
  }
  if (!(poisson > -1 && poisson < 0.5)) {
    return Violation{
        "poisson_ratio",
        fmt::format("Poisson's ratio must lie between -1 and 0.5, both excluded, not {}", poisson),
        poisson == 0.5 ? "an incompressible solid has no finite bulk modulus; 0.49 is rubber" : ""};
  }
  if (!(density > 0) || !std::isfinite(density)) {
    return Violation{"density", fmt::format("density must be positive, not {} kg/m^3", density),
                     ""};
  }
  for (const auto& [key, value] : {std::pair{"alpha1", material.damping.alpha1},
                                   std::pair{"alpha2", material.damping.alpha2}}) {
    if (!(value >= 0) || !std::isfinite(value)) {
      return Violation{key, fmt::format("{} must be finite and not negative, not {}", key, value),
                       "negative damping would let a mode grow"};
    }
  }
  return std::nullopt;
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& names) {
  std::string nearest = core::nearest_name(word, names);
  // "porcelain" is no slip of "sterling_porcelain", yet it is what was meant.
  if (nearest.empty()) {
    for (const std::string& name : names) {
      if (!word.empty() && name.ends_with(fmt::format("_{}", word))) nearest = name;
    }
  }
  return nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest);
}

/// `key=value,key=value`.
Material parse_fields(const std::string& text) {
  Material material;
  material.source = "given by hand";
  std::array<bool, kFields.size()> seen{};
  std::string_view rest = text;
  while (true) {
    const auto comma = rest.find(',');
    const std::string_view part = trimmed(rest.substr(0, comma));
    const auto equals = part.find('=');
    if (equals == std::string_view::npos) {
      throw core::InputError(fmt::format("material: \"{}\" is not of the form key=value", part),
                             fmt::format("keys are {}", fmt::join(field_names(), ", ")));
    }
    const std::string key(trimmed(part.substr(0, equals)));
    const auto field =
        std::find_if(kFields.begin(), kFields.end(), [&](const Field& f) { return key == f.name; });
    if (field == kFields.end()) {
      throw core::InputError(
          fmt::format("material: unknown key \"{}\"{}", key, did_you_mean(key, field_names())),
          fmt::format("keys are {}", fmt::join(field_names(), ", ")));
    }
    bool& was_seen = seen[static_cast<std::size_t>(field - kFields.begin())];
    if (was_seen) throw core::InputError(fmt::format("material: \"{}\" is given twice", key));
    was_seen = true;
    try {
      field->value(material) =
          core::parse_quantity(trimmed(part.substr(equals + 1)), field->dimension);
    } catch (const core::InputError& error) {
      throw core::InputError(fmt::format("material: {}: {}", key, error.message()), error.hint());
    }
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  for (std::size_t i = 0; i < kFields.size(); ++i) {
    if (kFields[i].required && !seen[i]) {
      throw core::InputError(fmt::format("material: \"{}\" is missing [{}]", kFields[i].name,
                                         core::unit_name(kFields[i].dimension)),
                             "write youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700");
    }
  }
  // A list of numbers has no name of its own: what was written is the name.
  material.name = text;
  return material;
}

}  // namespace

void check_material(const Material& material) {
  if (const auto broken = violation(material)) {
    throw core::InputError(material.name.empty()
                               ? fmt::format("material: {}", broken->message)
                               : fmt::format("material \"{}\": {}", material.name, broken->message),
                           broken->hint);
  }
}

Material parse_material(const std::string& text) {
  return parse_material(text, {});
}

Material parse_material(const std::string& text, const std::vector<Material>& own) {
  const std::string name(trimmed(text));
  if (name.find('=') != std::string::npos) {
    Material material = parse_fields(name);
    check_material(material);
    return material;
  }
  std::vector<std::string> names;
  for (const auto* list : {&own, &preset_materials()}) {
    for (const Material& material : *list) {
      if (material.name == name) {
        check_material(material);
        return material;
      }
      if (std::find(names.begin(), names.end(), material.name) == names.end()) {
        names.push_back(material.name);
      }
    }
  }
  throw core::InputError(
      name.empty() ? "material: no name given"
                   : fmt::format("unknown material \"{}\"{}", name, did_you_mean(name, names)),
      fmt::format("known: {}; or key=value pairs such as "
                  "youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700",
                  fmt::join(names, ", ")));
}

std::vector<Material> read_materials(const std::string& path) {
  core::ConfigNode root = core::ConfigNode::parse(core::read_text_file(path), path);
  std::vector<Material> materials;
  for (const std::string& name : root.keys()) {
    // Such a name could never be told from a list of numbers.
    if (name.empty() || name.find_first_of("=,") != std::string::npos) {
      root.fail(name, "a material's name must not be empty nor contain \"=\" or \",\"");
    }
    core::ConfigNode node = root.child(name);
    Material material;
    material.name = name;
    for (const Field& field : kFields) {
      field.value(material) = node.quantity(
          field.name, field.dimension, field.required ? std::nullopt : std::optional<double>(0.0));
    }
    material.source = node.text("source", path);
    node.finish();
    if (const auto broken = violation(material)) {
      node.fail(broken->key, broken->message, broken->hint);
    }
    materials.push_back(std::move(material));
  }
  root.finish();
  return materials;
}

}  // namespace carillon::synth
