#include "dataset/samples/damping_columns.hpp"

#include <cmath>

namespace carillon::dataset::samples {

std::vector<std::string> damping_column_units(
    const std::vector<synth::material::Material>& materials) {
  std::vector<std::string> units;
  for (const synth::material::Material& material : materials) {
    for (std::size_t i = 0; i < material.damping.parameters.size(); ++i) {
      const std::string unit = synth::damping::parameter_unit(material.damping.kind, i);
      if (i == units.size()) units.push_back(unit);
      if (units[i] != unit) units[i] = "SI";
    }
  }
  while (units.size() < 2) {
    units.push_back(
        synth::damping::parameter_unit(synth::damping::DampingKind::rayleigh, units.size()));
  }
  return units;
}

void add_damping_columns(const synth::damping::DampingModel& model,
                         const std::vector<std::string>& units, core::Columns& columns) {
  columns.add("damping_model", std::string(synth::damping::form_of(model.kind).name));
  for (std::size_t i = 0; i < units.size(); ++i) {
    const double value = i < model.parameters.size() ? model.parameters[i] : std::nan("");
    columns.add(synth::damping::parameter_name(i), value, units[i]);
  }
}

}  // namespace carillon::dataset::samples
