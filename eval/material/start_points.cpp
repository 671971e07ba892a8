#include "eval/material/start_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::eval::material {

namespace {

/// The `maximum` features or modes of greatest weight, heaviest first.
std::vector<std::size_t> heaviest(const std::vector<double>& weights, std::size_t maximum) {
  std::vector<std::size_t> order(weights.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return weights[a] > weights[b]; });
  order.resize(std::min(order.size(), maximum));
  return order;
}

std::vector<double> prominences(std::span<const features::Feature> features,
                                const MatchScale& scale) {
  std::vector<double> weights;
  for (const FeaturePlace& place : places_of(features, scale)) weights.push_back(place.prominence);
  return weights;
}

/// `count` of some items without replacement, likelier the heavier (Efraimidis and Spirakis 2006).
std::vector<std::size_t> draw(const std::vector<std::size_t>& items,
                              const std::vector<double>& weights, std::size_t count,
                              core::RandomStream& random) {
  std::vector<double> keys;
  for (const std::size_t item : items) {
    // The lightest may come last, but come they may.
    keys.push_back(std::log(1 - random.uniform()) / std::max(weights[item], 1e-6));
  }
  std::vector<std::size_t> drawn;
  for (const std::size_t place : heaviest(keys, count)) drawn.push_back(items[place]);
  return drawn;
}

}  // namespace

std::vector<double> eigenvalues_damped_by(const std::function<double(double)>& c, double value,
                                          double low, double high) {
  std::vector<double> roots;
  const double step = std::exp2(0.125);  // of the eigenvalue: its root is a frequency
  double before = c(low) - value;
  for (double left = low; left < high; left *= step) {
    const double right = std::min(left * step, high);
    const double after = c(right) - value;
    if (std::isfinite(before) && std::isfinite(after) && (before < 0) != (after < 0)) {
      std::uintmax_t steps = 60;
      const auto bracket = boost::math::tools::toms748_solve(
          [&](double lambda) { return c(lambda) - value; }, left, right, before, after,
          boost::math::tools::eps_tolerance<double>(40), steps);
      roots.push_back(0.5 * (bracket.first + bracket.second));
    }
    before = after;
  }
  return roots;
}

std::vector<synth::damping::DampingModel> damping_starts(
    std::span<const features::Feature> features, const damping::DampingLaw& law,
    const MatchScale& scale, const StartOptions& options) {
  std::vector<features::Feature> dry;  // what the room does not hide
  for (const features::Feature& feature : features) {
    if (!feature.reverberant) dry.push_back(feature);
  }
  const std::vector<double> weights = prominences(dry, scale);
  const std::vector<std::size_t> dominant = heaviest(weights, options.dominant);
  const auto part =
      static_cast<std::size_t>(std::ceil(options.fraction * static_cast<double>(dominant.size())));
  std::size_t count = std::max(part, law.parameters + 1);
  std::vector<synth::damping::DampingModel> models;
  std::string reason;
  std::string hint;
  for (std::size_t s = 0; s < options.samples; ++s) {
    core::RandomStream random(options.seed, s, "material.sample");
    const auto chosen = s == 0 ? dominant : draw(dominant, weights, count, random);
    std::vector<features::Feature> sample;
    for (const std::size_t index : chosen) sample.push_back(dry[index]);
    try {
      const damping::FitOptions fit{.estimator = damping::Estimator::least_squares,
                                    .confidence = false};
      models.push_back(damping::fit_damping(damping::damping_data(sample), law, fit).model);
    } catch (const core::InputError& error) {
      if (reason.empty()) {
        reason = error.message();
        hint = error.hint();
      }
    }
    if (count >= dominant.size()) break;  // every sample would be the first
  }
  if (models.empty()) {
    throw core::InputError(
        fmt::format("{} feature{} of the recording cannot begin a {} damping model: {}", dry.size(),
                    dry.size() == 1 ? "" : "s", synth::damping::form_of(law.kind).name, reason),
        hint.empty() ? "a model of fewer parameters, or a longer recording" : hint);
  }
  return models;
}

std::vector<Start> start_points(std::span<const features::Feature> features,
                                const StruckModes& modes,
                                const std::vector<synth::damping::DampingModel>& damping,
                                double contact_time, HeardMotion motion, const Reference& reference,
                                const StartOptions& options) {
  const auto paired = heaviest(prominences(features, reference.options.match), options.paired);
  std::vector<double> loudness;
  for (std::size_t i = 0; i < modes.gains.size(); ++i) loudness.push_back(std::abs(modes.gains[i]));
  const auto struck = heaviest(loudness, options.modes);
  const double low = modes.eigenvalues.front() * options.min_modulus / modes.specific_modulus;
  const double high = modes.eigenvalues.back() * options.max_modulus / modes.specific_modulus;

  std::vector<Start> starts;
  for (std::size_t s = 0; s < damping.size(); ++s) {
    const auto c = synth::damping::damping_function(damping[s]);
    for (const std::size_t f : paired) {
      std::vector<double> tuned = {features::eigenvalue(features[f])};
      if (!features[f].reverberant) {
        const auto damped = eigenvalues_damped_by(c, 2 * features[f].decay_rate, low, high);
        tuned.insert(tuned.end(), damped.begin(), damped.end());
      }
      for (const double lambda : tuned) {
        for (const std::size_t m : struck) {
          Start start;
          start.sample = s;
          start.candidate.damping = damping[s];
          start.candidate.contact_time = contact_time;
          const double modulus = modes.specific_modulus * lambda / modes.eigenvalues[m];
          if (!(modulus >= options.min_modulus && modulus <= options.max_modulus)) continue;
          start.candidate.specific_modulus = modulus;
          HeardCandidate heard =
              heard_candidate(modes, start.candidate, motion, reference.low, reference.high);
          const auto at = std::find(heard.modes.begin(), heard.modes.end(), m);
          if (at == heard.modes.end()) continue;
          const auto place = static_cast<std::size_t>(at - heard.modes.begin());
          start.candidate.scale = features[f].amplitude / heard.tones[place].amplitude;
          for (features::Feature& tone : heard.tones) tone.amplitude *= start.candidate.scale;
          start.match = match_ratio_product(reference, heard);
          starts.push_back(std::move(start));
        }
      }
    }
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.match > b.match; });
  return starts;
}

}  // namespace carillon::eval::material
