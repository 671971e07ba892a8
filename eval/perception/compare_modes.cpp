#include "eval/perception/compare_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/perception/assignment.hpp"

namespace carillon::eval::perception {

namespace {

using core::nan;
/// So that modes too weak to weigh anything find partners too, after all others have.
constexpr double min_weight = 1e-6;
/// Decay rates below ring for longer than any clip [1/s].
constexpr double slowest = 1e-3;

double cents_between(const features::Feature& a, const features::Feature& b) {
  return core::cents(b.frequency / a.frequency);
}

double energy(const features::Feature& mode) {
  return mode.amplitude * mode.amplitude / (4 * std::max(mode.decay_rate, slowest));
}

void check(std::span<const features::Feature> features) {
  for (const features::Feature& mode : features) {
    if (!(mode.frequency > 0 && mode.amplitude > 0) || !std::isfinite(mode.decay_rate)) {
      throw core::InputError(
          fmt::format("a mode of {} Hz, {} 1/s and amplitude {} cannot be compared", mode.frequency,
                      mode.decay_rate, mode.amplitude));
    }
  }
}

/// The same modes with their amplitudes a time after the onset.
std::vector<features::Feature> later(std::span<const features::Feature> features, double time) {
  std::vector<features::Feature> modes(features.begin(), features.end());
  for (features::Feature& mode : modes) mode.amplitude *= std::exp(-mode.decay_rate * time);
  return modes;
}

void set_errors(MatchedMode& pair, const features::Feature& a, const features::Feature& b,
                const JustNoticeable& jnd) {
  const double first = std::max(a.decay_rate, slowest), second = std::max(b.decay_rate, slowest);
  pair.cents = cents_between(a, b);
  pair.decay_ratio = second / first;
  pair.level = core::amplitude_decibels(b.amplitude / a.amplitude);
  const bool damped = std::min(first, second) > jnd.damped_decay_rate;
  pair.pitch_jnd = std::abs(pair.cents) / (damped ? jnd.damped_pitch : jnd.pitch);
  pair.decay_jnd = a.reverberant || b.reverberant
                       ? nan
                       : std::abs(std::log(pair.decay_ratio)) / std::log(jnd.decay_ratio);
  pair.level_jnd = std::abs(pair.level) / jnd.level;
}

JndSummary summarise(std::span<const MatchedMode> pairs, double MatchedMode::*error) {
  double sum = 0, weights = 0, worst = 0;
  for (const MatchedMode& pair : pairs) {
    if (pair.weight == 0 || std::isnan(pair.*error)) continue;
    sum += pair.weight * (pair.*error);
    weights += pair.weight;
    worst = std::max(worst, pair.*error);
  }
  return weights > 0 ? JndSummary{sum / weights, worst} : JndSummary{nan, nan};
}

/// Energies of a sound's modes, in all and matched.
struct Energies {
  double all = 0;
  double matched = 0;

  double fraction() const { return all > 0 ? matched / all : nan; }
};

}  // namespace

ModeComparison compare_modes(std::span<const features::Feature> reference,
                             std::span<const features::Feature> other,
                             const ModeComparisonOptions& options) {
  check(reference);
  check(other);
  const auto heard = later(reference, options.from), heard_other = later(other, options.from);
  const auto places = material::places_of(heard, options.match);
  const auto others = material::places_of(heard_other, options.match);
  std::vector<double> gains(reference.size() * other.size(), 0.0);
  for (std::size_t i = 0; i < reference.size(); ++i) {
    for (std::size_t j = 0; j < other.size(); ++j) {
      if (std::abs(cents_between(reference[i], other[j])) > options.widest) continue;
      const double weight =
          std::sqrt((min_weight + places[i].prominence) * (min_weight + others[j].prominence));
      gains[i * other.size() + j] =
          weight * material::similarity(places[i], others[j], options.match);
    }
  }
  const auto partners = best_pairs(gains, reference.size(), other.size());

  ModeComparison comparison;
  Energies first, second;
  std::vector<bool> taken(other.size(), false);
  for (std::size_t i = 0; i < reference.size(); ++i) {
    first.all += energy(heard[i]);
    if (partners[i] == unpaired) {
      comparison.reference_only.push_back(i);
      continue;
    }
    MatchedMode pair;
    pair.reference = i;
    pair.other = partners[i];
    pair.weight = std::sqrt(places[i].prominence * others[pair.other].prominence);
    set_errors(pair, reference[i], other[pair.other], options.jnd);
    comparison.matched.push_back(pair);
    taken[pair.other] = true;
    first.matched += energy(heard[i]);
  }
  for (std::size_t j = 0; j < other.size(); ++j) {
    second.all += energy(heard_other[j]);
    if (taken[j]) second.matched += energy(heard_other[j]);
    if (!taken[j]) comparison.other_only.push_back(j);
  }
  std::sort(comparison.matched.begin(), comparison.matched.end(),
            [&](const MatchedMode& a, const MatchedMode& b) {
              return reference[a.reference].frequency < reference[b.reference].frequency;
            });
  comparison.reference_fraction = first.fraction();
  comparison.other_fraction = second.fraction();
  const bool whole = comparison.reference_only.empty() && comparison.other_only.empty();
  const double unmatched =
      whole ? 0 : std::max(0.0, first.all - first.matched + second.all - second.matched);
  comparison.unmatched_level = core::decibels(unmatched / (first.all + second.all));
  comparison.pitch = summarise(comparison.matched, &MatchedMode::pitch_jnd);
  comparison.decay = summarise(comparison.matched, &MatchedMode::decay_jnd);
  comparison.level = summarise(comparison.matched, &MatchedMode::level_jnd);
  return comparison;
}

}  // namespace carillon::eval::perception
