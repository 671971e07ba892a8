#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
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
#include "synth/room/wall_materials.hpp"
#include "synth/support/supports.hpp"

namespace carillon::cli {

namespace {

nlohmann::json list_materials() {
  nlohmann::json list = nlohmann::json::array();
  for (const synth::material::Material& m : synth::material::preset_materials()) {
    list.push_back(scene::to_json(m));
    list.back()["bar_speed_m_per_s"] = std::sqrt(m.elastic.youngs_modulus / m.elastic.density);
  }
  return list;
}

nlohmann::json list_walls() {
  nlohmann::json list = nlohmann::json::array();
  for (const synth::room::WallMaterial& wall : synth::room::wall_materials()) {
    list.push_back({{"name", wall.name},
                    {"meaning", wall.meaning},
                    {"absorption", wall.absorption},
                    {"source", wall.source}});
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
                    {"stiffness_n_per_m", kind.stiffness},
                    {"resistance_ns_per_m", kind.resistance},
                    {"bed_stiffness_n_per_m3", kind.bed_stiffness},
                    {"bed_resistance_ns_per_m3", kind.bed_resistance},
                    {"shear", kind.shear},
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

/// Whether an entry has every word, in any of its texts and whatever the letters' case.
bool has_words(const nlohmann::json& entry, const std::vector<std::string>& words) {
  std::string all;
  for (const nlohmann::json& value : entry.flatten())
    if (value.is_string()) all += value.get<std::string>() + '\n';
  const auto folded = [](std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  };
  all = folded(all);
  return std::all_of(words.begin(), words.end(), [&](const std::string& word) {
    return all.find(folded(word)) != std::string::npos;
  });
}

/// A line for each; of a few also where their numbers are from.
void print_sources(const nlohmann::json& entry, bool wanted) {
  if (wanted) fmt::print("    {}\n", entry.at("source").get<std::string>());
}

void print_materials(const nlohmann::json& list, bool sources) {
  fmt::print("{:<26} {:<8} {:>9} {:>6} {:>8} {:>9}  {}\n", "name", "group", "E [GPa]", "nu",
             "[kg/m3]", "c [m/s]", "damping [1/s]");
  bool any_anisotropic = false;
  for (const nlohmann::json& m : list) {
    const bool anisotropic = m.contains("stiffness_pa");
    any_anisotropic = any_anisotropic || anisotropic;
    fmt::print("{:<26} {:<8} {:>8.4g}{} {:>6.3g} {:>8.5g} {:>9.4g}  {}\n",
               m.at("name").get<std::string>(), m.value("group", ""),
               m.at("youngs_modulus_pa").get<double>() / 1e9, anisotropic ? '*' : ' ',
               m.at("poisson_ratio").get<double>(), m.at("density_kg_m3").get<double>(),
               m.at("bar_speed_m_per_s").get<double>(),
               m.at("damping").at("formula").get<std::string>());
    print_sources(m, sources);
  }
  fmt::print("\nc = sqrt(E / density), the speed of sound in a thin bar");
  if (any_anisotropic) fmt::print("; *: isotropic mean of an anisotropic solid");
  fmt::print("{}\n",
             sources ? "" : "; carillon list materials WORD ... tells where values are from");
}

void print_walls(const nlohmann::json& list, bool sources) {
  fmt::print("{:<24}", "absorption at [Hz]");
  for (const double centre : synth::room::octave_centres) fmt::print(" {:>6.0f}", centre);
  fmt::print("\n");
  for (const nlohmann::json& wall : list) {
    fmt::print("{:<24}", wall.at("name").get<std::string>());
    for (const nlohmann::json& a : wall.at("absorption")) fmt::print(" {:>6.3g}", a.get<double>());
    fmt::print("  {}\n", wall.at("meaning").get<std::string>());
    print_sources(wall, sources);
  }
}

}  // namespace

void add_list(Program& program, Context& context) {
  static const std::map<std::string, nlohmann::json (*)()> lists = {
      {"materials", list_materials}, {"shapes", list_shapes},     {"effects", list_effects},
      {"models", list_models},       {"strikers", list_strikers}, {"supports", list_supports},
      {"noises", list_noises},       {"textures", list_textures}, {"classifiers", list_classifiers},
      {"columns", list_columns},     {"walls", list_walls}};
  const std::string names =
      "materials, walls (of rooms), shapes, effects, models, strikers, supports, noises, textures, "
      "classifiers or columns (of a dataset)";
  Command& command = program.add("list",
                                 "materials, walls, shapes, effects, damping models, strikers, "
                                 "supports, noises, textures, classifiers or columns by name",
                                 Needs::nothing);
  std::vector<std::string> known;
  for (const auto& [name, make] : lists) known.push_back(name);
  auto what = std::make_shared<std::string>();
  command.option("what", *what, names).required().one_of(known);
  auto words = std::make_shared<std::vector<std::string>>();
  command.option("word", *words,
                 "only entries with all of these words, in any of their texts; materials and walls "
                 "then tell where their numbers are from");
  command.footer(
      "Examples:\n"
      "  carillon list materials\n"
      "  carillon list materials bronze\n"
      "  carillon list walls carpet\n"
      "  carillon list shapes --json");
  command.does([&context, what, words] {
    if (!context.speaks()) return;
    nlohmann::json list = nlohmann::json::array();
    for (nlohmann::json& entry : lists.at (*what)())
      if (has_words(entry, *words)) list.push_back(std::move(entry));
    const bool sources = !words->empty();
    if (context.json) {
      fmt::print("{}\n", list.dump(2));
    } else if (list.empty()) {
      fmt::print("no {} with {}\n", *what, fmt::join(*words, " and "));
    } else if (*what == "materials") {
      print_materials(list, sources);
    } else if (*what == "walls") {
      print_walls(list, sources);
    } else {
      print_list(list);
    }
  });
}

}  // namespace carillon::cli
