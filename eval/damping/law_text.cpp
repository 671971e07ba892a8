#include "eval/damping/law_text.hpp"

#include <fmt/format.h>

#include <charconv>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "eval/damping/detail/scaled_law.hpp"

namespace carillon::eval::damping {

using synth::damping::DampingKind;

DampingLaw damping_law(const std::string& word) {
  constexpr std::size_t usual_terms = 3;  // as in Sterling 2019, Table 3.1
  constexpr std::size_t max_terms = 20;
  const std::string series = synth::damping::form_of(DampingKind::caughey).name;
  if (word == series) return {DampingKind::caughey, usual_terms, ""};
  if (word.starts_with(series + ":")) {
    std::size_t terms = 0;
    const char* end = word.data() + word.size();
    const auto read = std::from_chars(word.data() + series.size() + 1, end, terms);
    if (read.ec != std::errc() || read.ptr != end || terms < 1 || terms > max_terms) {
      throw core::InputError(fmt::format("\"{}\" is no Caughey series", word),
                             fmt::format("caughey:3 for three terms; 1 to {}", max_terms));
    }
    return {DampingKind::caughey, terms, ""};
  }
  for (const synth::damping::DampingForm& form : synth::damping::damping_forms()) {
    if (form.kind != DampingKind::expression && word == form.name) {
      return {form.kind, form.min_parameters, ""};
    }
  }
  DampingLaw law{DampingKind::expression, 0, word};
  law.parameters = parameter_count(law);
  return law;
}

std::vector<NamedLaw> damping_laws(const std::string& words) {
  if (words == "all") return damping_laws("rayleigh,caughey,power,hybrid");
  std::vector<std::string> names(1);
  int depth = 0;
  for (const char letter : words) {
    depth += letter == '(' ? 1 : letter == ')' ? -1 : 0;
    if (letter == ',' && depth == 0) {
      names.emplace_back();
    } else if (letter != ' ' || !names.back().empty()) {
      names.back() += letter;
    }
  }
  std::vector<NamedLaw> laws;
  for (const std::string& name : names) {
    if (name.empty()) {
      throw core::InputError(fmt::format("\"{}\" names no law between two commas", words),
                             "rayleigh,hybrid for two laws, all for all");
    }
    for (const NamedLaw& law : laws) {
      if (law.name == name) {
        throw core::InputError(fmt::format("\"{}\" is in the list of laws twice", name));
      }
    }
    laws.push_back({name, damping_law(name)});
  }
  return laws;
}

std::string formula_of(const DampingLaw& law) {
  if (law.kind == DampingKind::expression) return "c = " + law.expression;
  if (law.kind != DampingKind::caughey) return synth::damping::form_of(law.kind).formula;
  std::string text = "c = alpha1";
  for (std::size_t k = 1; k < law.parameters; ++k) {
    text += fmt::format(" + {} lambda", synth::damping::parameter_name(k));
    if (k > 1) text += fmt::format("^{}", k);
  }
  return text;
}

const char* name_of(Estimator estimator) {
  switch (estimator) {
    case Estimator::mixture:
      return "mixture";
    case Estimator::emg:
      return "emg";
    case Estimator::emg_relative:
      return "emg_relative";
    case Estimator::least_squares:
      return "least_squares";
    default:
      return "lower_bound";
  }
}

Estimator estimator_named(const std::string& name) {
  std::vector<std::string> names;
  for (const Estimator estimator : all_estimators) {
    if (name == name_of(estimator)) return estimator;
    names.emplace_back(name_of(estimator));
  }
  throw core::InputError(fmt::format("there is no estimator \"{}\"", name),
                         fmt::format("{}", fmt::join(names, ", ")));
}

}  // namespace carillon::eval::damping
