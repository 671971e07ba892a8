#include "scene/material_json.hpp"

namespace carillon::scene {

nlohmann::json to_json(const synth::material::Material& material) {
  const synth::damping::DampingModel& model = material.damping;
  nlohmann::json damping = {{"model", synth::damping::form_of(model.kind).name},
                            {"formula", synth::damping::formula_of(model)}};
  if (!model.expression.empty()) damping["expression"] = model.expression;
  for (std::size_t i = 0; i < model.parameters.size(); ++i) {
    damping[synth::damping::parameter_name(i)] = model.parameters[i];
  }
  nlohmann::json entry = {{"name", material.name},
                          {"youngs_modulus_pa", material.elastic.youngs_modulus},
                          {"poisson_ratio", material.elastic.poisson_ratio},
                          {"density_kg_m3", material.elastic.density},
                          {"damping", damping},
                          {"source", material.source},
                          {"appearance", render::looks::to_json(appearance_of(material))}};
  if (!material.group.empty()) entry["group"] = material.group;
  if (const auto& anisotropy = material.elastic.anisotropy) {
    nlohmann::json rows = nlohmann::json::array();
    for (Eigen::Index i = 0; i < 6; ++i) {
      const Eigen::Vector<double, 6> row = material.elastic.youngs_modulus * anisotropy->row(i);
      rows.push_back(std::vector<double>(row.begin(), row.end()));
    }
    entry["stiffness_pa"] = rows;
  }
  if (model.kind == synth::damping::DampingKind::rayleigh) {
    entry["alpha1_per_s"] = model.parameters.at(0);
    entry["alpha2_s"] = model.parameters.at(1);
  }
  return entry;
}

}  // namespace carillon::scene
