#include "synth/damping/damping_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "core/error.hpp"

namespace carillon::synth::damping {

namespace {

using core::InputError;

/// The model of a name; none for a formula. "expression" is what list calls a formula, not a name.
const DampingForm* find_form(const std::string& word) {
  for (const DampingForm& form : damping_forms()) {
    if (form.kind != DampingKind::expression && word == form.name) return &form;
  }
  return nullptr;
}

}  // namespace

std::optional<int> alpha_number(const std::string& key) {
  constexpr std::string_view stem = "alpha";
  if (!key.starts_with(stem) || key.size() == stem.size() || key[stem.size()] == '0') return {};
  int number = 0;
  const char* end = key.data() + key.size();
  const auto read = std::from_chars(key.data() + stem.size(), end, number);
  if (read.ec != std::errc() || read.ptr != end || number < 1) return {};
  return number;
}

core::Dimension alpha_dimension(const std::string& word, int number) {
  // 1/s is not a frequency in Hz, so that alpha1 takes plain numbers only.
  const bool series = word.empty() || word == "rayleigh" || word == "caughey";
  return series && number == 2 ? core::Dimension::time : core::Dimension::none;
}

DampingModel make_damping(const std::string& word, const std::map<int, double>& alphas) {
  const std::size_t last = alphas.empty() ? 0 : static_cast<std::size_t>(alphas.rbegin()->first);
  DampingModel model;
  const DampingForm* form = word.empty() ? &form_of(DampingKind::rayleigh) : find_form(word);
  if (form == nullptr) {
    form = &form_of(DampingKind::expression);
    model.expression = word;
  }
  model.kind = form->kind;
  if (last > form->max_parameters) {
    throw InputError(
        fmt::format("{} damping has no {}", form->name, parameter_name(last - 1)),
        word.empty() ? "name the model: damping: caughey or damping: hybrid" : form->formula);
  }
  // Rayleigh's terms may be left out one by one; where others lack one it was forgotten.
  const bool rayleigh = form->kind == DampingKind::rayleigh;
  model.parameters.assign(rayleigh ? 2 : last, 0.0);
  for (std::size_t i = 0; i < std::max(last, form->min_parameters); ++i) {
    const auto found = alphas.find(static_cast<int>(i) + 1);
    if (found != alphas.end()) {
      model.parameters[i] = found->second;
    } else if (!rayleigh) {
      throw InputError(fmt::format("{} damping lacks {}", form->name, parameter_name(i)),
                       form->formula);
    }
  }
  return model;
}

}  // namespace carillon::synth::damping
