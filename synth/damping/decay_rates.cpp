#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/damping/damping.hpp"

namespace carillon::synth::damping {

namespace {

using core::InputError;

/// Steps of the search for negative damping.
constexpr int steps = 4095;

double eigenvalue_at(double frequency) {
  const double omega = 2 * std::numbers::pi * frequency;
  return omega * omega;
}

void check_regions(const solvers::modes::Modes& modes, std::size_t models) {
  const auto count = static_cast<Eigen::Index>(modes.size());
  const auto regions = static_cast<Eigen::Index>(models);
  if (modes.kinetic_fraction.rows() != count || modes.strain_fraction.rows() != count ||
      modes.kinetic_fraction.cols() != regions || modes.strain_fraction.cols() != regions) {
    throw InputError(fmt::format("decay rates: {} dampings for modes of {} regions", models,
                                 modes.kinetic_fraction.cols()));
  }
}

/// One region's part of a mode's c.
double region_part(const std::function<double(double)>& c, double at_rest, double lambda,
                   double kinetic, double strain) {
  if (!std::isfinite(at_rest)) return c(lambda) * (kinetic + strain) / 2;
  return at_rest * kinetic + (c(lambda) - at_rest) * strain;
}

/// Frequency where c changes between negative and not; `a` and `b` lie on either side.
double edge_between(const std::function<double(double)>& c, double a, double b) {
  const bool negative = c(eigenvalue_at(a)) < 0;
  while (std::abs(b - a) > 1e-9 * a) {
    const double middle = std::sqrt(a * b);
    if (middle == a || middle == b) break;
    ((c(eigenvalue_at(middle)) < 0) == negative ? a : b) = middle;
  }
  return std::sqrt(a * b);
}

}  // namespace

DecayRates clamped_decay_rates(const solvers::modes::Modes& modes,
                               std::span<const DampingModel> regions) {
  if (!modes.given_decay_rates.empty()) return {modes.given_decay_rates, {}};
  check_regions(modes, regions.size());
  std::vector<std::function<double(double)>> functions;
  std::vector<double> at_rest;
  for (const DampingModel& model : regions) {
    functions.push_back(damping_function(model));
    at_rest.push_back(functions.back()(0));
  }
  DecayRates rates;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const double lambda = modes.eigenvalues[i];
    const auto row = static_cast<Eigen::Index>(i);
    double c = 0;
    if (functions.size() == 1) {
      c = functions.front()(lambda);
    } else {
      for (std::size_t r = 0; r < functions.size(); ++r) {
        const auto column = static_cast<Eigen::Index>(r);
        c += region_part(functions[r], at_rest[r], lambda, modes.kinetic_fraction(row, column),
                         modes.strain_fraction(row, column));
      }
    }
    if (!std::isfinite(c)) {
      std::vector<std::string> formulas;
      for (const DampingModel& model : regions) formulas.push_back(formula_of(model));
      throw InputError(fmt::format("the damping of the mode at {:.6g} Hz is not finite ({})",
                                   modes.frequency(i), fmt::join(formulas, "; ")),
                       "change the model, or leave the mode out of the band");
    }
    if (c < 0) rates.negative.push_back(i);
    rates.values.push_back(std::max(0.0, c / 2));
  }
  return rates;
}

std::vector<double> decay_rates(const solvers::modes::Modes& modes,
                                std::span<const DampingModel> regions) {
  DecayRates rates = clamped_decay_rates(modes, regions);
  if (!rates.negative.empty()) {
    throw InputError(describe_negative(modes, regions, rates.negative),
                     "a mode would grow for ever; change the model or the band, or in a "
                     "configuration write negative_damping: clamp for no damping there, "
                     "drop to leave such modes out");
  }
  return std::move(rates.values);
}

std::vector<NegativeRange> negative_ranges(const DampingModel& model, double low_hz,
                                           double high_hz) {
  if (!(low_hz > 0 && high_hz > low_hz && std::isfinite(high_hz))) {
    throw InputError(fmt::format("negative damping: {} to {} Hz is no band", low_hz, high_hz));
  }
  const auto c = damping_function(model);
  std::vector<NegativeRange> ranges;
  double before = low_hz;
  bool inside = false;
  for (int i = 0; i <= steps; ++i) {
    const double f = i == steps ? high_hz : low_hz * std::pow(high_hz / low_hz, i / double(steps));
    const bool negative = c(eigenvalue_at(f)) < 0;
    if (negative && !inside) ranges.push_back({i == 0 ? f : edge_between(c, before, f), f});
    if (!negative && inside) ranges.back().high = edge_between(c, before, f);
    if (negative) ranges.back().high = std::max(ranges.back().high, f);
    inside = negative;
    before = f;
  }
  return ranges;
}

std::string describe_negative(const solvers::modes::Modes& modes,
                              std::span<const DampingModel> regions,
                              std::span<const std::size_t> negative) {
  if (negative.empty()) return "no mode has negative damping";
  std::string text = fmt::format(
      "the damping of {} of {} modes is negative, from {:.6g} to {:.6g} Hz", negative.size(),
      modes.size(), modes.frequency(negative.front()), modes.frequency(negative.back()));
  if (regions.size() != 1) return text;
  text += fmt::format(" ({}", formula_of(regions.front()));
  const double low = modes.frequency(0), high = modes.frequency(modes.size() - 1);
  if (low > 0 && high > low) {
    std::vector<std::string> ranges;
    for (const NegativeRange& range : negative_ranges(regions.front(), low, high)) {
      ranges.push_back(fmt::format("{:.6g} to {:.6g} Hz", range.low, range.high));
    }
    if (!ranges.empty()) text += fmt::format(" is below zero from {}", fmt::join(ranges, ", "));
  }
  return text + ")";
}

}  // namespace carillon::synth::damping
