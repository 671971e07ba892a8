// Reads configurations as the program's commands do, and says what they asked for.
// scripts/make_schema and tests/end_to_end/schema.py talk to it: first line out: names and units
// that the program knows; then for every line in, {"reader": "build", "file": PATH}, a line out
// with the refusal or null, what was asked, and the resolved configuration.
#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "core/config.hpp"
#include "core/config_record.hpp"
#include "core/error.hpp"
#include "dataset/configuration/configuration.hpp"
#include "dataset/sweep/sweep.hpp"
#include "eval/accuracy/accuracy_config.hpp"
#include "eval/learning/known_methods.hpp"
#include "eval/studies/datasets.hpp"
#include "eval/studies/learning/learning_config.hpp"
#include "eval/studies/learning/search.hpp"
#include "eval/studies/learning/sections.hpp"
#include "mpi/comm.hpp"
#include "render/maps/generated_maps.hpp"
#include "scene/effect.hpp"
#include "solvers/families/families.hpp"
#include "synth/contact/striker.hpp"
#include "synth/material/material.hpp"
#include "synth/recording/noise_generators.hpp"
#include "synth/room/wall_materials.hpp"
#include "synth/support/supports.hpp"

using namespace carillon;
using nlohmann::ordered_json;

namespace {

constexpr core::Dimension dimensions[] = {
    core::Dimension::none,       core::Dimension::length,   core::Dimension::time,
    core::Dimension::frequency,  core::Dimension::pressure, core::Dimension::density,
    core::Dimension::mass,       core::Dimension::speed,    core::Dimension::angle,
    core::Dimension::force,      core::Dimension::impulse,  core::Dimension::stiffness,
    core::Dimension::resistance, core::Dimension::memory,   core::Dimension::level};

template <class List>
ordered_json names_in(const List& list) {
  ordered_json names = ordered_json::array();
  for (const auto& one : list) names.push_back(one.name);
  return names;
}

/// What the program knows by name, and its units.
ordered_json vocabulary() {
  ordered_json known;
  for (const core::Dimension dimension : dimensions) {
    ordered_json units = ordered_json::object();
    for (const std::string& unit : core::unit_names(dimension)) {
      units[unit] = core::parse_quantity("1 " + unit, dimension);
    }
    known["units"][core::dimension_name(dimension)] = {{"unit", core::unit_name(dimension)},
                                                       {"units", units}};
  }
  for (const solvers::families::Family& family : solvers::families::families()) {
    ordered_json parameters = ordered_json::object();
    for (const solvers::families::FamilyParameter& parameter : family.parameters) {
      parameters[parameter.name] = {{"default", {parameter.low, parameter.high}},
                                    {"meaning", parameter.meaning}};
    }
    known["shapes"][family.name] = {{"meaning", family.description}, {"parameters", parameters}};
  }
  for (const render::maps::GeneratedMap& map : render::maps::generated_maps()) {
    known["maps"][map.name] = {{"meaning", map.description}, {"parameters", map.defaults}};
  }
  known["materials"] = names_in(synth::material::preset_materials());
  known["walls"] = names_in(synth::room::wall_materials());
  known["supports"] = names_in(synth::support::preset_supports());
  for (const synth::support::SupportKind& kind : synth::support::preset_supports()) {
    if (kind.coefficient > 0) known["touches"].push_back(kind.name);
  }
  known["strikers"] = names_in(synth::contact::preset_strikers());
  known["noises"] = synth::recording::noise_kind_names();
  known["methods"] = names_in(eval::learning::known_methods());
  return known;
}

ordered_json to_json(const std::vector<std::string>& path, const core::ConfigAsk& ask,
                     const std::string* fallback) {
  ordered_json asked = {{"path", path}, {"kind", ask.kind}, {"optional", ask.optional}};
  if (ask.dimension != core::Dimension::none) {
    asked["dimension"] = core::dimension_name(ask.dimension);
  }
  if (std::isfinite(ask.low)) asked["low"] = ask.low;
  if (std::isfinite(ask.high)) asked["high"] = ask.high;
  if (ask.above_low) asked["above_low"] = true;
  if (ask.count > 0) asked["count"] = ask.count;
  if (!ask.allowed.empty()) {
    asked["allowed"] = std::vector<std::string>(ask.allowed.begin(), ask.allowed.end());
  }
  if (fallback != nullptr) asked["default"] = *fallback;
  return asked;
}

/// What `carillon evaluate` and `carillon train` read of a configuration; all of its variants.
void read_evaluated(const std::string& file, const std::string& text) {
  using namespace eval::studies;
  constexpr EvaluationSection sections[] = {{"damping", read_damping_validation},
                                            {"classification", read_classification},
                                            {"transfer", read_transfer_section},
                                            {"spectrograms", read_spectrograms}};
  dataset::run::BuildOptions options;
  options.config = file;
  const EvaluatedDatasets datasets(options, MPI_COMM_WORLD);
  core::ConfigNode root = core::ConfigNode::parse(text, file);
  if (root.has("train")) read_train_section(root, file);
  if (root.has("search")) read_searches(text, options);
  if (!root.has("evaluate")) return;
  core::ConfigNode node = root.child("evaluate");
  for (const EvaluationSection& section : sections) {
    if (!node.has(section.name)) continue;
    core::ConfigNode own = node.child(section.name);
    section.read(own, root, datasets);
  }
  node.finish();
}

/// @return the resolved configuration, where the reader makes one
std::string read(const std::string& reader, const std::string& file) {
  const std::string text = core::read_text_file(file);
  if (reader == "build") {
    const auto sweep = dataset::sweep::read_sweep(text, file, {});
    if (!sweep) return dataset::configuration::read_build_config(text, file, {}).resolved;
    for (const dataset::sweep::SweepVariant& variant : sweep->variants) {
      std::vector<std::string> overrides = {"sweep="};
      overrides.insert(overrides.end(), variant.overrides.begin(), variant.overrides.end());
      dataset::configuration::read_build_config(text, file, overrides);
    }
    return "";
  }
  if (reader == "evaluate") {
    read_evaluated(file, text);
  } else if (reader == "accuracy") {
    return eval::accuracy::read_accuracy_config(text, file, {}).resolved;
  } else if (reader == "materials") {
    synth::material::read_materials(file);
  } else {
    throw core::InputError(fmt::format("there is no reader \"{}\"", reader));
  }
  return "";
}

}  // namespace

int main(int argc, char** argv) {
  const mpi::Environment environment(argc, argv);
  std::cout << vocabulary().dump() << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    const ordered_json wanted = ordered_json::parse(line);
    std::set<std::string> seen;
    ordered_json answer = {{"refusal", nullptr}, {"asked", ordered_json::array()}};
    const core::ConfigRecord record([&](const std::string& file, const auto& path,
                                        const core::ConfigAsk& ask, const std::string* fallback) {
      if (file != wanted.at("file")) return;  // of materials, say
      ordered_json asked = to_json(path, ask, fallback);
      if (seen.insert(asked.dump()).second) answer["asked"].push_back(std::move(asked));
    });
    try {
      answer["resolved"] = read(wanted.at("reader"), wanted.at("file"));
    } catch (const core::Error& error) {
      answer["refusal"] = error.what();
    }
    std::cout << answer.dump() << std::endl;
  }
}
