#include "synth/material/detail/material_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/error.hpp"
#include "core/text.hpp"
#include "synth/damping/damping_text.hpp"

namespace carillon::synth::material {

namespace {

using core::InputError;

struct Pair {
  std::string key, value;
};

/// Position of the next comma that stands outside parentheses.
std::size_t next_comma(std::string_view text) {
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '(') ++depth;
    if (text[i] == ')') --depth;
    if (text[i] == ',' && depth <= 0) return i;
  }
  return std::string_view::npos;
}

std::string known_keys() {
  std::vector<std::string> names;
  for (const ElasticField& field : elastic_fields) names.emplace_back(field.name);
  return fmt::format("keys are {}, damping, alpha1, alpha2, ...", fmt::join(names, ", "));
}

std::vector<Pair> split_pairs(std::string_view rest) {
  std::vector<Pair> pairs;
  while (true) {
    const auto comma = next_comma(rest);
    const std::string_view part = core::trimmed(rest.substr(0, comma));
    const auto equals = part.find('=');
    if (equals == std::string_view::npos) {
      throw InputError(fmt::format("material: \"{}\" is not of the form key=value", part),
                       known_keys());
    }
    Pair pair{std::string(core::trimmed(part.substr(0, equals))),
              std::string(core::trimmed(part.substr(equals + 1)))};
    for (const Pair& before : pairs) {
      if (before.key == pair.key) {
        throw InputError(fmt::format("material: \"{}\" is given twice", pair.key));
      }
    }
    pairs.push_back(std::move(pair));
    if (comma == std::string_view::npos) return pairs;
    rest.remove_prefix(comma + 1);
  }
}

double number_of(const Pair& pair, core::Dimension dimension) {
  try {
    return core::parse_quantity(pair.value, dimension);
  } catch (const InputError& error) {
    throw InputError(fmt::format("material: {}: {}", pair.key, error.message()), error.hint());
  }
}

[[noreturn]] void refuse_key(const std::string& key) {
  std::vector<std::string> names = {"damping", "alpha1", "alpha2", "alpha3"};
  for (const ElasticField& field : elastic_fields) names.emplace_back(field.name);
  throw InputError(fmt::format("material: unknown key \"{}\"{}", key, did_you_mean(key, names)),
                   known_keys());
}

}  // namespace

Material parse_fields(const std::string& text) {
  const std::vector<Pair> pairs = split_pairs(text);
  Material material;
  material.source = "given by hand";
  std::string word;
  for (const Pair& pair : pairs) {
    if (pair.key != "damping") continue;
    word = pair.value;
    if (word.empty()) throw InputError("material: damping: there is no formula and no name");
  }
  std::vector<std::string> seen;
  std::map<int, double> alphas;
  for (const Pair& pair : pairs) {
    const auto field = std::find_if(elastic_fields.begin(), elastic_fields.end(),
                                    [&](const ElasticField& f) { return pair.key == f.name; });
    if (field != elastic_fields.end()) {
      field->value(material) = number_of(pair, field->dimension);
      seen.push_back(pair.key);
    } else if (const auto number = damping::alpha_number(pair.key)) {
      alphas[*number] = number_of(pair, damping::alpha_dimension(word, *number));
    } else if (pair.key != "damping") {
      refuse_key(pair.key);
    }
  }
  for (const ElasticField& field : elastic_fields) {
    if (std::find(seen.begin(), seen.end(), field.name) == seen.end()) {
      throw InputError(fmt::format("material: \"{}\" is missing [{}]", field.name,
                                   core::unit_name(field.dimension)),
                       "write youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700");
    }
  }
  material.damping = damping::make_damping(word, alphas);
  // A list of numbers has no name of its own: what was written is the name.
  material.name = text;
  return material;
}

}  // namespace carillon::synth::material
