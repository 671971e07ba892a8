#include "eval/recorded/compare_recorded.hpp"

#include <algorithm>
#include <cmath>

#include "core/numbers.hpp"
#include "eval/recorded/peak_match.hpp"
#include "eval/statistics/summary.hpp"

namespace carillon::eval::recorded {

namespace {

double energy(const features::Feature& mode) {
  return mode.amplitude * mode.amplitude / (4 * std::max(mode.decay_rate, 1e-3));
}

/// Modes that are not too weak beside the strongest.
std::vector<features::Feature> audible(const std::vector<features::Feature>& tones,
                                       double min_level) {
  double strongest = 0;
  for (const features::Feature& tone : tones) strongest = std::max(strongest, energy(tone));
  std::vector<features::Feature> kept;
  for (const features::Feature& tone : tones) {
    if (energy(tone) >= strongest * std::pow(10, min_level / 10)) kept.push_back(tone);
  }
  return kept;
}

double energy_of(std::span<const features::Feature> tones) {
  double sum = 0;
  for (const features::Feature& tone : tones) sum += energy(tone);
  return sum;
}

/// The gain that makes all energies together equal; 1 where either side is silent.
double energy_gain(std::span<const RecordedTones> strikes,
                   const std::vector<std::vector<features::Feature>>& synthetic) {
  double recorded = 0, made = 0;
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    recorded += energy_of(strikes[i].recorded);
    made += energy_of(synthetic[i]);
  }
  return recorded > 0 && made > 0 ? std::sqrt(recorded / made) : 1;
}

void amplify(std::vector<std::vector<features::Feature>>& synthetic, double gain) {
  for (auto& tones : synthetic) {
    for (features::Feature& tone : tones) tone.amplitude *= gain;
  }
}

/// Compares with the present gain.
void compare(std::span<const RecordedTones> strikes, const RecordedOptions& options,
             RecordedComparison& comparison) {
  comparison.strikes.clear();
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    comparison.strikes.push_back(
        perception::compare_modes(strikes[i].recorded, comparison.synthetic[i], options.modes));
  }
}

std::vector<double> levels_of(const RecordedComparison& comparison) {
  std::vector<double> levels;
  for (const perception::ModeComparison& strike : comparison.strikes) {
    for (const perception::MatchedMode& pair : strike.matched) levels.push_back(pair.level);
  }
  return levels;
}

/// Takes what matched modes are too loud by out of the synthetic modes and, if asked, of the
/// levels that were told.
void settle_gain(RecordedComparison& comparison, bool tell) {
  const std::vector<double> levels = levels_of(comparison);
  if (levels.empty()) return;
  const double excess = core::median(levels);
  const double gain = std::pow(10, -excess / 20);
  comparison.gain *= gain;
  amplify(comparison.synthetic, gain);
  if (!tell) return;
  for (perception::ModeComparison& strike : comparison.strikes) {
    for (perception::MatchedMode& pair : strike.matched) pair.level -= excess;
  }
}

double mean_fraction(const std::vector<perception::ModeComparison>& strikes,
                     double perception::ModeComparison::*fraction) {
  double sum = 0, count = 0;
  for (const perception::ModeComparison& strike : strikes) {
    if (std::isnan(strike.*fraction)) continue;
    sum += strike.*fraction;
    ++count;
  }
  return sum / count;
}

std::vector<double> frequencies(std::span<const features::Feature> tones) {
  std::vector<double> all;
  for (const features::Feature& tone : tones) all.push_back(tone.frequency);
  return all;
}

RecordedSummary summarise(std::span<const RecordedTones> strikes,
                          const RecordedComparison& comparison, double widest) {
  RecordedSummary all;
  std::vector<double> cents, distances, ratios, levels;
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    all.recorded += strikes[i].recorded.size();
    all.synthetic += comparison.synthetic[i].size();
    all.matched += comparison.strikes[i].matched.size();
    all.matched_by_chance += pairs_by_chance(frequencies(comparison.synthetic[i]),
                                             frequencies(strikes[i].recorded), widest);
    for (const perception::MatchedMode& pair : comparison.strikes[i].matched) {
      cents.push_back(pair.cents);
      distances.push_back(std::abs(pair.cents));
      levels.push_back(std::abs(pair.level));
      if (!std::isnan(pair.decay_jnd)) ratios.push_back(pair.decay_ratio);
    }
  }
  all.recorded_fraction =
      mean_fraction(comparison.strikes, &perception::ModeComparison::reference_fraction);
  all.synthetic_fraction =
      mean_fraction(comparison.strikes, &perception::ModeComparison::other_fraction);
  all.cents = spread_of(cents);
  all.distance = spread_of(distances);
  all.decay_ratio = spread_of(ratios);
  all.level_error = spread_of(levels);
  return all;
}

}  // namespace

Spread spread_of(std::span<const double> values) {
  return {core::quantile(values, 0.5), core::quantile(values, 0.1), core::quantile(values, 0.9)};
}

RecordedComparison compare_recorded(std::span<const RecordedTones> strikes,
                                    const RecordedOptions& options) {
  RecordedComparison comparison;
  for (const RecordedTones& strike : strikes) {
    comparison.synthetic.push_back(audible(strike.synthetic, options.min_level));
  }
  comparison.gain = energy_gain(strikes, comparison.synthetic);
  amplify(comparison.synthetic, comparison.gain);
  compare(strikes, options, comparison);
  settle_gain(comparison, false);
  compare(strikes, options, comparison);
  settle_gain(comparison, true);
  comparison.all = summarise(strikes, comparison, options.modes.widest);
  return comparison;
}

}  // namespace carillon::eval::recorded
