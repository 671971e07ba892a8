#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "eval/learning/known_methods.hpp"
#include "render/maps/generated_maps.hpp"
#include "scene/columns.hpp"
#include "scene/effect.hpp"
#include "scene/family_json.hpp"
#include "scene/material_json.hpp"
#include "synth/contact/striker.hpp"
#include "synth/material/material.hpp"
#include "synth/recording/noise_generators.hpp"
#include "synth/support/supports.hpp"

namespace carillon::cli {

namespace {

nlohmann::json list_materials() {
  nlohmann::json list = nlohmann::json::array();
  for (const synth::material::Material& m : synth::material::preset_materials()) {
    list.push_back(scene::to_json(m));
  }
  return list;
}

nlohmann::json list_shapes() {
  nlohmann::json list = nlohmann::json::array();
  for (const solvers::families::Family& family : solvers::families::families()) {
    list.push_back(scene::to_json(family));
  }
  return list;
}

nlohmann::json list_effects() {
  nlohmann::json list = nlohmann::json::array();
  for (const scene::Effect& effect : scene::effects()) {
    nlohmann::json entry = {{"name", effect.name},
                            {"description", effect.description},
                            {"key", effect.key},
                            {"stage", effect.stage}};
    list.push_back(std::move(entry));
  }
  return list;
}

nlohmann::json list_strikers() {
  nlohmann::json list = nlohmann::json::array();
  for (const synth::contact::Striker& striker : synth::contact::preset_strikers()) {
    list.push_back({{"name", striker.name},
                    {"mass_kg", striker.mass},
                    {"radius_m", striker.radius},
                    {"youngs_modulus_pa", striker.youngs_modulus},
                    {"poisson_ratio", striker.poisson_ratio},
                    {"restitution", striker.restitution},
                    {"source", striker.source}});
  }
  return list;
}

nlohmann::json list_supports() {
  nlohmann::json list = nlohmann::json::array();
  for (const synth::support::SupportKind& kind : synth::support::preset_supports()) {
    list.push_back({{"name", kind.name},
                    {"coefficient_s_per_m", kind.coefficient},
                    {"friction", kind.friction},
                    {"source", kind.source}});
  }
  return list;
}

nlohmann::json list_noises() {
  nlohmann::json list = nlohmann::json::array();
  const std::vector<std::string>& names = synth::recording::noise_kind_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    list.push_back(
        {{"name", names[i]}, {"spectrum", synth::recording::noise_kind_spectra().at(i)}});
  }
  return list;
}

nlohmann::json list_textures() {
  nlohmann::json list = nlohmann::json::array();
  for (const render::maps::GeneratedMap& map : render::maps::generated_maps()) {
    list.push_back(
        {{"name", map.name}, {"description", map.description}, {"defaults", map.defaults}});
  }
  return list;
}

nlohmann::json list_models() {
  nlohmann::json list = nlohmann::json::array();
  for (const synth::damping::DampingForm& form : synth::damping::damping_forms()) {
    nlohmann::json units = nlohmann::json::object();
    for (std::size_t i = 0; i < form.units.size(); ++i) {
      units[synth::damping::parameter_name(i)] = form.units[i];
    }
    list.push_back({{"name", form.name},
                    {"formula", form.formula},
                    {"description", form.description},
                    {"units", units}});
  }
  return list;
}

nlohmann::json list_columns() {
  nlohmann::json list = nlohmann::json::array();
  for (const core::ColumnRule& rule : scene::columns()) {
    list.push_back({{"name", rule.name},
                    {"type", *rule.type == '\0' ? "float32|int16" : rule.type},
                    {"row", rule.inner},
                    {"unit", rule.units},
                    {"when", rule.when},
                    {"may_be_nan", rule.may_be_nan},
                    {"meaning", rule.meaning}});
  }
  return list;
}

nlohmann::json list_classifiers() {
  nlohmann::json list = nlohmann::json::array();
  for (const eval::learning::Method& method : eval::learning::known_methods()) {
    const nlohmann::ordered_json all = eval::learning::to_json(method);
    nlohmann::json entry = {{"name", method.name}, {"modalities", all.at("modalities")}};
    if (method.kind == eval::learning::MethodKind::network) {
      entry["branches"] = all.at("branches");
      if (method.branches.size() > 1) entry["fusion"] = all.at("fusion");
    } else {
      entry["baseline"] = all.at("kind");
    }
    list.push_back(std::move(entry));
  }
  return list;
}

void print_value(const nlohmann::json& value) {
  if (value.is_string()) {
    fmt::print("{}", value.get<std::string>());
  } else if (value.is_object()) {
    std::vector<std::string> parts;
    for (const auto& [key, part] : value.items()) {
      parts.push_back(
          fmt::format("{}: {}", key, part.is_string() ? part.get<std::string>() : part.dump()));
    }
    fmt::print("{}", fmt::join(parts, ", "));
  } else {
    fmt::print("{}", value.dump());
  }
}

void print_list(const nlohmann::json& list) {
  for (const nlohmann::json& entry : list) {
    fmt::print("{}\n", entry.at("name").get<std::string>());
    for (const auto& [key, value] : entry.items()) {
      if (key == "name" || value.empty() || value == false) continue;
      if (key == "parameters") {
        for (const nlohmann::json& p : value) {
          fmt::print("    {:<18} {:.4g} to {:.4g} m: {}\n", p.at("name").get<std::string>(),
                     p.at("low_m").get<double>(), p.at("high_m").get<double>(),
                     p.at("meaning").get<std::string>());
        }
        continue;
      }
      fmt::print("    {:<18} ", key);
      print_value(value);
      fmt::print("\n");
    }
  }
}

}  // namespace

void add_list(Program& program, Context& context) {
  static const std::map<std::string, nlohmann::json (*)()> lists = {
      {"materials", list_materials}, {"shapes", list_shapes},     {"effects", list_effects},
      {"models", list_models},       {"strikers", list_strikers}, {"supports", list_supports},
      {"noises", list_noises},       {"textures", list_textures}, {"classifiers", list_classifiers},
      {"columns", list_columns}};
  const std::string names =
      "materials, shapes, effects, models, strikers, supports, noises, textures, classifiers or "
      "columns (of a dataset)";
  Command& command = program.add("list",
                                 "materials, shapes, effects, damping models, strikers, supports, "
                                 "noises, textures, classifiers "
                                 "or columns by name",
                                 Needs::nothing);
  std::vector<std::string> known;
  for (const auto& [name, make] : lists) known.push_back(name);
  auto what = std::make_shared<std::string>();
  command.option("what", *what, names).required().one_of(known);
  command.footer(
      "Examples:\n"
      "  carillon list materials\n"
      "  carillon list shapes --json");
  command.does([&context, what] {
    if (!context.speaks()) return;
    const nlohmann::json list = lists.at(*what)();
    if (context.json) {
      fmt::print("{}\n", list.dump(2));
    } else {
      print_list(list);
    }
  });
}

}  // namespace carillon::cli
