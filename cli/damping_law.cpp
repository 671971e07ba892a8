#include "cli/damping_law.hpp"

#include "eval/damping/expression_law.hpp"

namespace carillon::cli {

eval::DampingLaw damping_law(const std::string& model, std::size_t parameters) {
  for (const synth::DampingForm& form : synth::damping_forms()) {
    if (form.kind != synth::DampingKind::expression && model == form.name) {
      const bool series = form.least != form.most;
      return {form.kind, series ? parameters : form.least, ""};
    }
  }
  return {synth::DampingKind::expression, eval::count_alphas(model), model};
}

}  // namespace carillon::cli
