#include "synth/material/material.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/did_you_mean.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "synth/material/detail/material_fields.hpp"

namespace carillon::synth::material {

std::optional<core::Fault> material_fault(const Material& material) {
  if (auto fault = solvers::elements::elastic_fault(material.elastic)) return fault;
  return damping::damping_fault(material.damping);
}

const std::vector<std::string>& material_groups() {
  static const std::vector<std::string> groups = {"metal", "wood",    "stone",  "ceramic",
                                                  "glass", "plastic", "rubber", "other"};
  return groups;
}

render::looks::Appearance appearance_of(const Material& material) {
  if (material.appearance) return *material.appearance;
  return render::looks::appearance_of(material.name, material.group);
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
      name.empty()
          ? "material: no name given"
          : fmt::format("unknown material \"{}\"{}", name, core::did_you_mean(name, names)),
      "carillon list materials [WORD ...] names them; or key=value pairs such as "
      "youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700");
}

}  // namespace carillon::synth::material
