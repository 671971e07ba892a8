#include "synth/damping/damping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "synth/damping/damping_expression.hpp"

namespace carillon::synth::damping {

namespace {

using core::InputError;

constexpr std::size_t any = std::numeric_limits<std::size_t>::max();

/// c of every kind but expressions.
double built_in(DampingKind kind, std::span<const double> alpha, double lambda) {
  switch (kind) {
    case DampingKind::power:
      return alpha[0] * std::pow(lambda, alpha[1]);
    case DampingKind::hybrid:
      return alpha[0] + alpha[1] * std::pow(lambda, alpha[2]);
    default: {  // the series, of which Rayleigh's two terms are the shortest
      double c = 0;
      for (std::size_t k = alpha.size(); k-- > 0;) c = c * lambda + alpha[k];
      return c;
    }
  }
}

}  // namespace

DampingModel rayleigh_damping(double alpha1, double alpha2) {
  return {DampingKind::rayleigh, {alpha1, alpha2}, ""};
}

DampingModel scaled(DampingModel model, double factor) {
  switch (model.kind) {
    case DampingKind::expression:
      model.expression = fmt::format("{} * ({})", factor, model.expression);
      break;
    case DampingKind::power:
      model.parameters.at(0) *= factor;
      break;
    case DampingKind::hybrid:
      model.parameters.at(0) *= factor;
      model.parameters.at(1) *= factor;
      break;
    case DampingKind::rayleigh:
    case DampingKind::caughey:
      for (double& alpha : model.parameters) alpha *= factor;
      break;
  }
  return model;
}

const std::vector<DampingForm>& damping_forms() {
  static const std::vector<DampingForm> forms = {
      {DampingKind::rayleigh,
       "rayleigh",
       "c = alpha1 + alpha2 lambda",
       "mass- and stiffness-proportional (Sterling 2019, eq. 2.6 and 2.11)",
       2,
       2,
       {"1/s", "s"}},
      {DampingKind::caughey,
       "caughey",
       "c = alpha1 + alpha2 lambda + alpha3 lambda^2 + ...",
       "series of any length; may be negative in between (Sterling 2019, eq. 2.7 and 2.12 with "
       "omega^(2 j))",
       1,
       any,
       {"1/s", "s", "s^3"}},
      {DampingKind::power,
       "power",
       "c = alpha1 lambda^alpha2",
       "power law of generalised proportional damping (Sterling 2019, eq. 3.4)",
       2,
       2,
       {"s^(2 alpha2 - 1)", "1"}},
      {DampingKind::hybrid,
       "hybrid",
       "c = alpha1 + alpha2 lambda^alpha3",
       "constant and power law (Sterling 2019, eq. 4.1)",
       3,
       3,
       {"1/s", "s^(2 alpha3 - 1)", "1"}},
      {DampingKind::expression,
       "expression",
       "c = any formula of lambda, omega, f and alpha1, alpha2, ...",
       "written out in place of a model's name, as 6 + 1e-7*lambda (muParser)",
       0,
       any,
       {}},
  };
  return forms;
}

const DampingForm& form_of(DampingKind kind) {
  const auto& forms = damping_forms();
  return *std::find_if(forms.begin(), forms.end(),
                       [&](const DampingForm& form) { return form.kind == kind; });
}

std::string parameter_unit(DampingKind kind, std::size_t parameter) {
  if (kind == DampingKind::expression) return "SI";
  const auto& units = form_of(kind).units;
  return parameter < units.size() ? units[parameter] : fmt::format("s^{}", 2 * parameter - 1);
}

std::string parameter_name(std::size_t parameter) {
  return fmt::format("alpha{}", parameter + 1);
}

std::string formula_of(const DampingModel& model) {
  const auto& alpha = model.parameters;
  switch (model.kind) {
    case DampingKind::power:
      return fmt::format("c = {} lambda^{}", alpha.at(0), alpha.at(1));
    case DampingKind::hybrid:
      return fmt::format("c = {} + {} lambda^{}", alpha.at(0), alpha.at(1), alpha.at(2));
    case DampingKind::expression: {
      std::string text = "c = " + model.expression;
      for (std::size_t i = 0; i < alpha.size(); ++i) {
        text += fmt::format(", {} = {}", parameter_name(i), alpha[i]);
      }
      return text;
    }
    default: {
      std::string text;
      for (std::size_t k = 0; k < alpha.size(); ++k) {
        const std::string power = k == 0 ? "" : k == 1 ? " lambda" : fmt::format(" lambda^{}", k);
        text += k == 0 ? "c = " : alpha[k] < 0 ? " - " : " + ";
        text += fmt::format("{}{}", k == 0 ? alpha[k] : std::abs(alpha[k]), power);
      }
      return text;
    }
  }
}

std::optional<core::Fault> damping_fault(const DampingModel& model) {
  const DampingForm& form = form_of(model.kind);
  const auto& alpha = model.parameters;
  if (alpha.size() < form.min_parameters || alpha.size() > form.max_parameters) {
    return core::Fault{
        "damping",
        fmt::format("{} damping takes {} parameter{}, not {}", form.name, form.min_parameters,
                    form.min_parameters == 1 ? " or more" : "s", alpha.size()),
        form.formula};
  }
  // A series may be negative in between and an expression anywhere; exponents may have any sign.
  std::size_t factors = 0;
  if (model.kind == DampingKind::power) factors = 1;
  if (model.kind == DampingKind::rayleigh || model.kind == DampingKind::hybrid) factors = 2;
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    if (!std::isfinite(alpha[i])) {
      return core::Fault{parameter_name(i),
                         fmt::format("{} must be finite, not {}", parameter_name(i), alpha[i]),
                         form.formula};
    }
    if (i < factors && alpha[i] < 0) {
      return core::Fault{
          parameter_name(i),
          fmt::format("{} must not be negative, but is {}", parameter_name(i), alpha[i]),
          "negative damping would let a mode grow"};
    }
  }
  if (model.kind == DampingKind::expression) {
    try {
      compile_expression(model.expression, alpha);
    } catch (const InputError& error) {
      return core::Fault{"damping", error.message(), error.hint()};
    }
  }
  return std::nullopt;
}

void check_damping(const DampingModel& model) {
  if (const auto fault = damping_fault(model)) throw InputError(fault->message, fault->hint);
}

bool is_undamped(const DampingModel& model) {
  const auto& alpha = model.parameters;
  const auto zero = [](double value) { return value == 0; };
  switch (model.kind) {
    case DampingKind::power:
      return alpha.at(0) == 0;
    case DampingKind::hybrid:
      return alpha.at(0) == 0 && alpha.at(1) == 0;
    case DampingKind::expression:
      return false;
    default:
      return std::all_of(alpha.begin(), alpha.end(), zero);
  }
}

std::function<double(double)> damping_function(const DampingModel& model) {
  check_damping(model);
  if (model.kind == DampingKind::expression) {
    return compile_expression(model.expression, model.parameters);
  }
  return [kind = model.kind, alpha = model.parameters](double lambda) {
    return built_in(kind, alpha, lambda);
  };
}

std::vector<double> damping_coefficients(const DampingModel& model,
                                         std::span<const double> lambda) {
  const auto c = damping_function(model);
  std::vector<double> values;
  values.reserve(lambda.size());
  for (const double value : lambda) values.push_back(c(value));
  return values;
}

}  // namespace carillon::synth::damping
