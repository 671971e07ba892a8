#include "synth/damping/damping_expression.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"
#include "synth/damping/damping.hpp"

namespace carillon::synth::damping {

namespace {

using core::InputError;

constexpr const char* remedy =
    "a formula of lambda [rad^2/s^2], omega [rad/s] and f [Hz] that gives c = 2 d [1/s], as "
    "6 + 1e-7*lambda, or a model by name: rayleigh, caughey, power, hybrid";

/// muParser keeps addresses of its variables, so they live and move together with it.
struct Formula {
  mu::Parser parser;
  double lambda = 1;
  double omega = 1;
  double frequency = 1;
  std::vector<double> parameters;

  double at(double value) {
    lambda = value;
    omega = std::sqrt(value);
    frequency = omega / (2 * std::numbers::pi);
    return parser.Eval();
  }
};

[[noreturn]] void refuse(const std::string& expression, std::size_t place, const std::string& what,
                         const std::string& hint = remedy, const std::string& near = "") {
  throw InputError(fmt::format("damping \"{}\": {} at character {}{}", expression, what, place + 1,
                               near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)),
                   hint);
}

/// muParser would let a formula set lambda.
void refuse_assignment(const std::string& expression) {
  for (std::size_t i = 0; i < expression.size(); ++i) {
    if (expression[i] != '=') continue;
    if (i + 1 < expression.size() && expression[i + 1] == '=') {
      ++i;
      continue;
    }
    if (i > 0 && std::string_view("<>!").find(expression[i - 1]) != std::string_view::npos)
      continue;
    refuse(expression, i, "a single \"=\" assigns", "write == to compare; the formula alone is c");
  }
}

/// A message of ours for what muParser stumbled over.
[[noreturn]] void explain(const std::string& expression, const mu::Parser::exception_type& error) {
  const std::string& token = error.GetToken();
  const auto place = static_cast<std::size_t>(std::max(0, error.GetPos()));
  switch (error.GetCode()) {
    case mu::ecUNASSIGNABLE_TOKEN: {
      std::vector<std::string> names = {"lambda",  "omega", "f",      "pi",  "sqrt", "exp",
                                        "ln",      "log10", "min",    "max", "abs",  "rayleigh",
                                        "caughey", "power", "hybrid", "sin", "cos",  "tanh"};
      if (token.starts_with("alpha")) {
        refuse(expression, place, fmt::format("{} has no value", token),
               fmt::format("give {}, or write its number into the formula", token));
      }
      refuse(expression, place, fmt::format("unknown name \"{}\"", token), remedy,
             core::nearest_name(token, names));
    }
    case mu::ecUNEXPECTED_EOF:
      refuse(expression, place, "the formula ends too early");
    case mu::ecMISSING_PARENS:
      refuse(expression, place, "a parenthesis is not closed");
    case mu::ecEMPTY_EXPRESSION:
      refuse(expression, 0, "there is no formula");
    default:
      refuse(
          expression, place,
          token.empty() ? "the formula cannot be read" : fmt::format("\"{}\" does not fit", token));
  }
}

}  // namespace

std::function<double(double)> compile_expression(const std::string& expression,
                                                 std::span<const double> parameters) {
  refuse_assignment(expression);
  auto formula = std::make_shared<Formula>();
  formula->parameters.assign(parameters.begin(), parameters.end());
  try {
    mu::Parser& parser = formula->parser;
    parser.DefineVar("lambda", &formula->lambda);
    parser.DefineVar("omega", &formula->omega);
    parser.DefineVar("f", &formula->frequency);
    parser.DefineConst("pi", std::numbers::pi);
    for (std::size_t i = 0; i < formula->parameters.size(); ++i) {
      parser.DefineVar(parameter_name(i), &formula->parameters[i]);
    }
    parser.SetExpr(expression);
    formula->at(1);
    if (parser.GetNumResults() != 1) {
      refuse(expression, expression.find(','), "a comma outside a function",
             "the formula gives one number; the decimal sign is a point");
    }
    const auto& used = parser.GetUsedVar();
    for (std::size_t i = 0; i < formula->parameters.size(); ++i) {
      if (!used.contains(parameter_name(i))) {
        throw InputError(fmt::format("damping \"{}\": {} is given, but does not stand in it",
                                     expression, parameter_name(i)),
                         "leave it out");
      }
    }
  } catch (const mu::Parser::exception_type& error) {
    explain(expression, error);
  }
  return [formula](double lambda) { return formula->at(lambda); };
}

}  // namespace carillon::synth::damping
