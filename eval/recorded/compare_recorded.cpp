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
double energy_gain(std::span<const RecordedTones> blows,
                   const std::vector<std::vector<features::Feature>>& synthetic) {
  double recorded = 0, made = 0;
  for (std::size_t i = 0; i < blows.size(); ++i) {
    recorded += energy_of(blows[i].recorded);
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
void compare(std::span<const RecordedTones> blows, const RecordedOptions& options,
             RecordedComparison& comparison) {
  comparison.blows.clear();
  for (std::size_t i = 0; i < blows.size(); ++i) {
    comparison.blows.push_back(
        perception::compare_modes(blows[i].recorded, comparison.synthetic[i], options.modes));
  }
}

std::vector<double> levels_of(const RecordedComparison& comparison) {
  std::vector<double> levels;
  for (const perception::ModeComparison& blow : comparison.blows) {
    for (const perception::MatchedMode& pair : blow.matched) levels.push_back(pair.level);
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
  for (perception::ModeComparison& blow : comparison.blows) {
    for (perception::MatchedMode& pair : blow.matched) pair.level -= excess;
  }
}

double mean_share(const std::vector<perception::ModeComparison>& blows,
                  double perception::ModeComparison::*share) {
  double sum = 0, count = 0;
  for (const perception::ModeComparison& blow : blows) {
    if (std::isnan(blow.*share)) continue;
    sum += blow.*share;
    ++count;
  }
  return sum / count;
}

std::vector<double> frequencies(std::span<const features::Feature> tones) {
  std::vector<double> all;
  for (const features::Feature& tone : tones) all.push_back(tone.frequency);
  return all;
}

RecordedSummary summarise(std::span<const RecordedTones> blows,
                          const RecordedComparison& comparison, double widest) {
  RecordedSummary all;
  std::vector<double> cents, distances, ratios, levels;
  for (std::size_t i = 0; i < blows.size(); ++i) {
    all.recorded += blows[i].recorded.size();
    all.synthetic += comparison.synthetic[i].size();
    all.matched += comparison.blows[i].matched.size();
    all.matched_by_chance += pairs_by_chance(frequencies(comparison.synthetic[i]),
                                             frequencies(blows[i].recorded), widest);
    for (const perception::MatchedMode& pair : comparison.blows[i].matched) {
      cents.push_back(pair.cents);
      distances.push_back(std::abs(pair.cents));
      levels.push_back(std::abs(pair.level));
      if (!std::isnan(pair.decay_jnd)) ratios.push_back(pair.decay_ratio);
    }
  }
  all.recorded_share = mean_share(comparison.blows, &perception::ModeComparison::reference_share);
  all.synthetic_share = mean_share(comparison.blows, &perception::ModeComparison::other_share);
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

RecordedComparison compare_recorded(std::span<const RecordedTones> blows,
                                    const RecordedOptions& options) {
  RecordedComparison comparison;
  for (const RecordedTones& blow : blows) {
    comparison.synthetic.push_back(audible(blow.synthetic, options.min_level));
  }
  comparison.gain = energy_gain(blows, comparison.synthetic);
  amplify(comparison.synthetic, comparison.gain);
  compare(blows, options, comparison);
  settle_gain(comparison, false);
  compare(blows, options, comparison);
  settle_gain(comparison, true);
  comparison.all = summarise(blows, comparison, options.modes.widest);
  return comparison;
}

}  // namespace carillon::eval::recorded
