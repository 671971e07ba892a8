#include "synth/material/material.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/text.hpp"
#include "synth/material/detail/material_fields.hpp"

namespace carillon::synth::material {

std::optional<core::Fault> material_fault(const Material& material) {
  if (auto fault = solvers::elements::elastic_fault(material.elastic)) return fault;
  return damping::damping_fault(material.damping);
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& names) {
  std::string nearest = core::nearest_name(word, names);
  // "porcelain" is no slip of "sterling_porcelain", yet it is what was meant.
  for (const std::string& name : names) {
    if (!nearest.empty()) break;
    if (!word.empty() && name.ends_with(fmt::format("_{}", word))) nearest = name;
  }
  return nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest);
}

void check_material(const Material& material) {
  if (const auto broken = material_fault(material)) {
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
  const std::string name(core::trimmed(text));
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

}  // namespace carillon::synth::material
