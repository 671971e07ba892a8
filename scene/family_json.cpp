#include "scene/family_json.hpp"

namespace carillon::scene {

nlohmann::json to_json(const solvers::families::Family& family) {
  nlohmann::json parameters = nlohmann::json::array();
  for (const solvers::families::FamilyParameter& p : family.parameters) {
    parameters.push_back(
        {{"name", p.name}, {"low_m", p.low}, {"high_m", p.high}, {"meaning", p.meaning}});
  }
  nlohmann::json entry = {
      {"name", family.name}, {"description", family.description}, {"parameters", parameters}};
  if (!family.usual_material.empty()) entry["usual_material"] = family.usual_material;
  return entry;
}

}  // namespace carillon::scene
