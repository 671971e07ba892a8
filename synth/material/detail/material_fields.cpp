#include "synth/material/detail/material_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "core/did_you_mean.hpp"
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
  for (const ElasticField& field : elastic_fields()) names.emplace_back(field.name);
  return fmt::format("keys are {}, stiffness, damping, alpha1, alpha2, ...",
                     fmt::join(names, ", "));
}

using core::Dimension;
using Values = std::vector<double>;
using solvers::elements::Voigt;

constexpr ElasticField density{"density", Dimension::density};

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
  std::vector<std::string> names = {"damping", "alpha1", "alpha2", "alpha3", "stiffness"};
  for (const ElasticField& field : elastic_fields()) names.emplace_back(field.name);
  throw InputError(
      fmt::format("material: unknown key \"{}\"{}", key, core::did_you_mean(key, names)),
      known_keys());
}

/// Moduli without which some strain would cost no energy.
bool is_positive(std::string_view name) {
  return name.starts_with('E') || name.starts_with('G') || name == "C11" || name == "C33" ||
         name == "C44";
}

/// Numbers between blanks.
Values list_of(const Pair& pair, Dimension dimension) {
  Values values;
  std::istringstream words(pair.value);
  for (std::string word; words >> word;) values.push_back(number_of({pair.key, word}, dimension));
  return values;
}

}  // namespace

const std::vector<ElasticLaw>& elastic_laws() {
  constexpr Dimension modulus = Dimension::pressure, ratio = Dimension::none;
  static const std::vector<ElasticLaw> laws = {
      {"isotropic", {{"youngs_modulus", modulus}, {"poisson_ratio", ratio}}, nullptr},
      {"orthotropic",
       {{"E1", modulus},
        {"E2", modulus},
        {"E3", modulus},
        {"nu23", ratio},
        {"nu13", ratio},
        {"nu12", ratio},
        {"G23", modulus},
        {"G13", modulus},
        {"G12", modulus}},
       [](const Values& v) {
         return solvers::elements::orthotropic_stiffness(
             {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}});
       }},
      {"cubic",
       {{"C11", modulus}, {"C12", modulus}, {"C44", modulus}},
       [](const Values& v) { return solvers::elements::cubic_stiffness(v[0], v[1], v[2]); }},
      {"hexagonal",
       {{"C11", modulus}, {"C12", modulus}, {"C13", modulus}, {"C33", modulus}, {"C44", modulus}},
       [](const Values& v) {
         return solvers::elements::hexagonal_stiffness(v[0], v[1], v[2], v[3], v[4]);
       }}};
  return laws;
}

std::vector<ElasticField> elastic_fields() {
  std::vector<ElasticField> fields;
  const auto add = [&fields](const ElasticField& field) {
    const std::string_view name = field.name;
    if (std::none_of(fields.begin(), fields.end(),
                     [name](const ElasticField& known) { return name == known.name; }))
      fields.push_back(field);
  };
  const auto& laws = elastic_laws();
  for (const ElasticField& field : laws.front().fields) add(field);
  add(density);
  for (const ElasticLaw& law : laws)
    for (const ElasticField& field : law.fields) add(field);
  return fields;
}

std::optional<core::Fault> make_elastic(const GivenElastic& given,
                                        solvers::elements::Elastic& elastic) {
  std::vector<std::string> names;
  for (const auto& [name, value] : given.constants)
    if (name != density.name) names.push_back(name);
  // The law that all of them belong to: the one with the fewest others.
  const ElasticLaw* chosen = nullptr;
  for (const ElasticLaw& law : elastic_laws()) {
    const bool knows_all = std::all_of(names.begin(), names.end(), [&law](const std::string& name) {
      return std::any_of(law.fields.begin(), law.fields.end(),
                         [&name](const ElasticField& field) { return name == field.name; });
    });
    if (knows_all && chosen == nullptr) chosen = &law;
  }
  if (chosen == nullptr || (given.stiffness && !names.empty()))
    return core::Fault{given.stiffness ? "stiffness" : names.front(),
                       fmt::format("{} belong to no law together",
                                   given.stiffness ? "stiffness and other constants"
                                                   : fmt::format("{}", fmt::join(names, ", "))),
                       "give the constants of one: isotropic, orthotropic, cubic, hexagonal, or "
                       "the stiffness matrix"};
  std::vector<ElasticField> wanted;
  if (!given.stiffness) wanted = chosen->fields;
  wanted.push_back(density);
  std::vector<ElasticField> missing;
  for (const ElasticField& field : wanted)
    if (!given.constants.contains(field.name)) missing.push_back(field);
  if (!missing.empty()) {
    std::vector<std::string> texts;
    for (const ElasticField& field : missing)
      texts.push_back(fmt::format("\"{}\" [{}]", field.name, core::unit_name(field.dimension)));
    const ElasticField& first = missing.front();
    return core::Fault{
        first.name,
        missing.size() == 1
            ? fmt::format("\"{}\" is missing [{}]", first.name, core::unit_name(first.dimension))
            : fmt::format("{} are missing of an {} solid", fmt::join(texts, ", "), chosen->name),
        chosen->stiffness == nullptr && !given.stiffness
            ? "write youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700"
            : ""};
  }
  Values values;
  for (const ElasticField& field : wanted) {
    values.push_back(given.constants.at(field.name));
    if (is_positive(field.name) && !(values.back() > 0))
      return core::Fault{field.name,
                         fmt::format("{} must be positive, not {}", field.name, values.back()), ""};
  }
  if (given.stiffness) {
    elastic = solvers::elements::anisotropic(*given.stiffness, values.back());
  } else if (chosen->stiffness != nullptr) {
    elastic = solvers::elements::anisotropic(chosen->stiffness(values), values.back());
  } else {
    elastic = {values[0], values[1], values[2], {}};
  }
  return {};
}

std::optional<Voigt> stiffness_matrix(const Values& entries) {
  Voigt c;
  if (entries.size() == 36) {
    c = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(entries.data());
    if (!((c - c.transpose()).norm() <= 1e-9 * c.norm())) return {};
    return (c + c.transpose()) / 2;
  }
  if (entries.size() != 21) return {};
  std::size_t next = 0;
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = i; j < 6; ++j) c(i, j) = c(j, i) = entries[next++];
  return c;
}

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
  GivenElastic given;
  std::map<int, double> alphas;
  const std::vector<ElasticField> fields = elastic_fields();
  for (const Pair& pair : pairs) {
    const auto field = std::find_if(fields.begin(), fields.end(),
                                    [&](const ElasticField& f) { return pair.key == f.name; });
    if (field != fields.end()) {
      given.constants[pair.key] = number_of(pair, field->dimension);
    } else if (pair.key == "stiffness") {
      given.stiffness = stiffness_matrix(list_of(pair, Dimension::pressure));
      if (!given.stiffness)
        throw InputError("material: stiffness is not a symmetric matrix of 6 x 6",
                         "write its 36 entries row by row, or the 21 of the upper triangle, with "
                         "blanks between them");
    } else if (const auto number = damping::alpha_number(pair.key)) {
      alphas[*number] = number_of(pair, damping::alpha_dimension(word, *number));
    } else if (pair.key != "damping") {
      refuse_key(pair.key);
    }
  }
  if (const auto fault = make_elastic(given, material.elastic))
    throw InputError("material: " + fault->message, fault->hint);
  material.damping = damping::make_damping(word, alphas);
  // A list of numbers has no name of its own: what was written is the name.
  material.name = text;
  return material;
}

}  // namespace carillon::synth::material
