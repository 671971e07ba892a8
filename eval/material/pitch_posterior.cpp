#include "eval/material/pitch_posterior.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <tuple>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::eval::material {

namespace {

constexpr double cent = std::numbers::ln2 / 1200;
/// Student's t of 4 degrees of freedom at 0.
constexpr double t_peak = 0.375;
/// Scales beyond which its density is nothing beside that of spurious tones.
constexpr double t_width = 12;
constexpr double poisson_step = 0.0125;
constexpr double coarse_scatters[] = {3, 9, 27};
constexpr double fine_scatters[] = {0.25, 0.5, 1, 2, 4, 8, 16, 32, 64};
/// Steps of the logarithm of the modulus: half of them in log frequency are within the smallest
/// scatter of either pass.
constexpr double coarse_step = 0.0035;
constexpr std::size_t fine_per_coarse = 14;
/// Candidates whose coarse evidence is so much smaller than the best are not looked at finely.
constexpr double negligible = 12;
constexpr std::size_t max_fine_cells = 400;
constexpr double most_error = 200;  // that modes can be sharp [cents]
constexpr double no_error = 0.05;   // [cents]
constexpr double sharpest = 1.25;   // estimates may be a fifth too low
constexpr double sharp_step = 2;    // [cents]
/// Part of a mode's estimated error by which it differs from the share that all modes have.
constexpr double own_sharpness = 0.03;
/// Scatters at which matches by chance are looked for [cents].
constexpr core::Range chance_scatters = {1, 20};
constexpr int random_moves = 24;
constexpr double random_move = 150 * cent;

/// Modes of one Poisson's ratio and sharpness, ready for candidates.
struct PreparedModes {
  double log_modulus = 0;
  double log_top = 0;             ///< of what is known
  std::vector<double> places;     ///< log frequency, ascending
  std::vector<double> variances;  ///< of each, in log frequency
  double widest_variance = 0;
  std::vector<double> weights, cumulative;  ///< the latter of those before each
};

double error_of(double estimated) {
  return std::isfinite(estimated) ? std::clamp(estimated, 0.0, most_error) : most_error;
}

PreparedModes prepared(const ModePitches& modes, double sharpness) {
  PreparedModes out;
  out.log_modulus = std::log(modes.specific_modulus);
  std::vector<std::tuple<double, double, double>> sorted;
  for (std::size_t i = 0; i < modes.frequencies.size(); ++i) {
    const double error = error_of(modes.errors[i]) * cent;
    sorted.emplace_back(std::log(modes.frequencies[i]) - sharpness * error, modes.weights[i],
                        std::pow(own_sharpness * error, 2));
  }
  std::sort(sorted.begin(), sorted.end());
  out.cumulative.push_back(0);
  for (const auto& [place, weight, variance] : sorted) {
    out.places.push_back(place);
    out.variances.push_back(variance);
    out.widest_variance = std::max(out.widest_variance, variance);
    out.weights.push_back(weight);
    out.cumulative.push_back(out.cumulative.back() + weight);
  }
  out.log_top = std::log(std::max(modes.complete_to_hz, 1e-9));
  return out;
}

/// Where a band lies among modes that are shifted by half the logarithm of the moduli's ratio.
struct Band {
  double shift = 0, low = 0, top = 0, weight = 0;
  double width() const { return top - low; }
};

Band band_of(const PreparedModes& modes, double log_modulus, const PitchPrior& prior) {
  Band band;
  band.shift = 0.5 * (log_modulus - modes.log_modulus);
  band.low = std::log(prior.min_frequency);
  band.top = std::min(std::log(prior.max_frequency), modes.log_top + band.shift);
  if (band.top <= band.low) return band;
  const auto before = [&](double place) {
    const auto at = std::lower_bound(modes.places.begin(), modes.places.end(), place - band.shift);
    return modes.cumulative[static_cast<std::size_t>(at - modes.places.begin())];
  };
  band.weight = before(band.top) - before(band.low);
  return band;
}

/// How much denser modes' tones are at a tone than spurious ones.
double density_ratio(const HeardTone& tone, const PreparedModes& modes, const Band& band,
                     double scatter) {
  const double common = scatter * cent * scatter * cent + tone.error * tone.error;
  const double reach = t_width * std::sqrt(common + modes.widest_variance);
  const double place = tone.log_frequency - band.shift;
  auto at = static_cast<std::size_t>(
      std::lower_bound(modes.places.begin(), modes.places.end(), place - reach) -
      modes.places.begin());
  double sum = 0;
  for (; at < modes.places.size() && modes.places[at] < place + reach; ++at) {
    if (modes.places[at] + band.shift < band.low || modes.places[at] + band.shift >= band.top) {
      continue;
    }
    const double distance = place - modes.places[at];
    const double variance = common + modes.variances[at];
    const double q = 1 + 0.25 * distance * distance / variance;
    sum += modes.weights[at] / (q * q * std::sqrt(q * variance));
  }
  return band.width() * t_peak * sum / band.weight;
}

double log_likelihood(std::span<const HeardTone> tones, const PreparedModes& modes,
                      double log_modulus, double scatter, const PitchPrior& prior) {
  const Band band = band_of(modes, log_modulus, prior);
  double product = 1;
  double sum = 0;
  for (const HeardTone& tone : tones) {
    if (tone.log_frequency < band.low || tone.log_frequency >= band.top) continue;
    const double ratio = band.weight > 0 ? density_ratio(tone, modes, band, scatter) : 0;
    product *= 1 - tone.certainty + tone.certainty * ratio;
    if (product > 1e200 || product < 1e-200) {
      sum += std::log(product);
      product = 1;
    }
  }
  return sum + std::log(product);
}

double log_of_sum(std::span<const double> logarithms) {
  const double largest = *std::max_element(logarithms.begin(), logarithms.end());
  double sum = 0;
  for (const double value : logarithms) sum += std::exp(value - largest);
  return largest + std::log(sum);
}

/// Log evidence of moduli a step apart, Poisson's ratio and scatter averaged.
std::vector<double> coarse_evidence(std::span<const HeardTone> tones,
                                    std::span<const PreparedModes> sets, double step,
                                    std::span<const double> scatters, const PitchPrior& prior) {
  const double low = std::log(prior.min_modulus);
  const auto count = static_cast<std::size_t>((std::log(prior.max_modulus) - low) / step);
  std::vector<double> evidence(count);
  std::vector<double> terms;
  for (std::size_t i = 0; i < count; ++i) {
    const double log_modulus = low + (static_cast<double>(i) + 0.5) * step;
    terms.clear();
    for (const PreparedModes& modes : sets) {
      for (const double scatter : scatters) {
        terms.push_back(log_likelihood(tones, modes, log_modulus, scatter, prior));
      }
    }
    evidence[i] = log_of_sum(terms) - std::log(static_cast<double>(terms.size()));
  }
  return evidence;
}

std::vector<PreparedModes> coarse_sets(std::span<const ModePitches> modes) {
  std::vector<PreparedModes> sets;
  for (const ModePitches& set : modes) sets.push_back(prepared(set, 0.5));
  return sets;
}

void check(std::span<const ModePitches> modes) {
  const auto none = [](const ModePitches& set) { return set.frequencies.empty(); };
  if (modes.empty() || std::any_of(modes.begin(), modes.end(), none)) {
    throw core::InputError("the assumed object has no mode in its band",
                           "raise --max-frequency, or check the object's size");
  }
}

std::vector<double> poisson_grid(std::span<const ModePitches> modes) {
  const double low = modes.front().poisson_ratio;
  const double high = modes.back().poisson_ratio;
  const int steps = static_cast<int>(std::lround((high - low) / poisson_step));
  std::vector<double> ratios = {low};
  for (int i = 1; i <= steps; ++i) ratios.push_back(low + (high - low) * i / steps);
  return ratios;
}

/// Shares of the modes' errors, in steps of 2 cents or so.
std::vector<double> sharpness_grid(std::span<const ModePitches> modes) {
  double largest = 0;
  for (const ModePitches& set : modes) {
    for (const double error : set.errors) largest = std::max(largest, error_of(error));
  }
  if (largest < no_error) return {0};
  const int steps = std::clamp(static_cast<int>(sharpest * largest / sharp_step), 5, 25);
  std::vector<double> grid;
  for (int i = 0; i <= steps; ++i) grid.push_back(sharpest * i / steps);
  return grid;
}

/// The candidate at which so much of the posterior is reached.
double quantile(const PitchPosterior& posterior, double fraction) {
  double sum = 0;
  for (std::size_t i = 0; i < posterior.probabilities.size(); ++i) {
    sum += posterior.probabilities[i];
    if (sum >= fraction) return posterior.log_moduli[i];
  }
  return posterior.log_moduli.back();
}

}  // namespace

double log_likelihood(std::span<const HeardTone> tones, const ModePitches& modes,
                      double specific_modulus, const PitchNuisance& nuisance,
                      const PitchPrior& prior) {
  return log_likelihood(tones, prepared(modes, nuisance.sharpness), std::log(specific_modulus),
                        nuisance.scatter, prior);
}

ModePitches pitches_at(std::span<const ModePitches> modes, double poisson_ratio) {
  for (std::size_t i = 0; i + 1 < modes.size(); ++i) {
    if (poisson_ratio <= modes[i + 1].poisson_ratio) {
      return between(modes[i], modes[i + 1], poisson_ratio);
    }
  }
  return modes.back();
}

double best_log_likelihood(std::span<const HeardTone> tones, const ModePitches& modes,
                           double specific_modulus, const PitchPrior& prior) {
  double best = -core::infinity;
  for (const double sharpness : sharpness_grid(std::span(&modes, 1))) {
    const PreparedModes ready = prepared(modes, sharpness);
    for (const double scatter : fine_scatters) {
      best =
          std::max(best, log_likelihood(tones, ready, std::log(specific_modulus), scatter, prior));
    }
  }
  return best;
}

PitchPosterior pitch_posterior(std::span<const HeardTone> tones, std::span<const ModePitches> modes,
                               const PitchPrior& prior) {
  check(modes);
  const std::vector<double> coarse =
      coarse_evidence(tones, coarse_sets(modes), coarse_step, coarse_scatters, prior);
  const double best = *std::max_element(coarse.begin(), coarse.end());
  // The best cells, with a neighbour at either side, finely.
  std::vector<std::size_t> order(coarse.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return coarse[a] > coarse[b]; });
  std::vector<bool> chosen(coarse.size(), false);
  for (std::size_t i = 0; i < std::min(order.size(), max_fine_cells); ++i) {
    if (coarse[order[i]] < best - negligible) break;
    for (std::size_t j = std::max<std::size_t>(order[i], 1) - 1;
         j <= std::min(order[i] + 1, coarse.size() - 1); ++j) {
      chosen[j] = true;
    }
  }
  PitchPosterior posterior;
  const double low = std::log(prior.min_modulus);
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    for (std::size_t k = 0; chosen[i] && k < fine_per_coarse; ++k) {
      posterior.log_moduli.push_back(
          low + coarse_step * (static_cast<double>(i) + (static_cast<double>(k) + 0.5) /
                                                            static_cast<double>(fine_per_coarse)));
    }
  }
  const std::vector<double> sharpnesses = sharpness_grid(modes);
  posterior.poisson_ratios = poisson_grid(modes);
  posterior.probabilities.assign(posterior.log_moduli.size(), 0.0);
  double highest = -std::numeric_limits<double>::infinity();
  for (const double ratio : posterior.poisson_ratios) {
    const ModePitches set = pitches_at(modes, ratio);
    double of_ratio = 0;
    for (const double sharpness : sharpnesses) {
      const PreparedModes ready = prepared(set, sharpness);
      for (std::size_t i = 0; i < posterior.log_moduli.size(); ++i) {
        for (const double scatter : fine_scatters) {
          const double value =
              log_likelihood(tones, ready, posterior.log_moduli[i], scatter, prior);
          const double likelihood = std::exp(value - best);
          posterior.probabilities[i] += likelihood;
          of_ratio += likelihood;
          if (value <= highest) continue;
          highest = value;
          posterior.best = {ratio, sharpness, scatter};
          posterior.best_modulus = std::exp(posterior.log_moduli[i]);
        }
      }
    }
    posterior.poisson_probabilities.push_back(of_ratio);
  }
  const double sum =
      std::accumulate(posterior.probabilities.begin(), posterior.probabilities.end(), 0.0);
  for (double& probability : posterior.probabilities) probability /= sum;
  for (double& probability : posterior.poisson_probabilities) probability /= sum;
  const double terms =
      static_cast<double>(posterior.poisson_ratios.size() * sharpnesses.size() *
                          std::size(fine_scatters) * fine_per_coarse * coarse.size());
  posterior.log_evidence = best + std::log(sum / terms);
  posterior.modulus = std::exp(quantile(posterior, 0.5));
  // A candidate stands for all around it.
  const double half = 0.5 * coarse_step / static_cast<double>(fine_per_coarse);
  posterior.confidence95 = {std::exp(quantile(posterior, 0.025) - half),
                            std::exp(quantile(posterior, 0.975) + half)};
  return posterior;
}

std::vector<ToneMatch> match_tones(std::span<const HeardTone> tones,
                                   std::span<const ModePitches> modes,
                                   const PitchPosterior& posterior, const PitchPrior& prior) {
  const ModePitches set = pitches_at(modes, posterior.best.poisson_ratio);
  const PreparedModes ready = prepared(set, posterior.best.sharpness);
  const Band band = band_of(ready, std::log(posterior.best_modulus), prior);
  std::vector<ToneMatch> matches;
  for (std::size_t i = 0; i < tones.size(); ++i) {
    const HeardTone& tone = tones[i];
    if (tone.log_frequency < band.low || tone.log_frequency >= band.top) continue;
    const double modal = tone.certainty * density_ratio(tone, ready, band, posterior.best.scatter);
    const double probability = modal / (1 - tone.certainty + modal);
    if (!(probability > 0.5)) continue;
    const double place = tone.log_frequency - band.shift;
    std::size_t nearest = 0;
    for (std::size_t j = 1; j < ready.places.size(); ++j) {
      if (std::abs(ready.places[j] - place) < std::abs(ready.places[nearest] - place)) nearest = j;
    }
    const auto same = std::find_if(matches.begin(), matches.end(),
                                   [nearest](const ToneMatch& one) { return one.mode == nearest; });
    if (same == matches.end()) {
      matches.push_back({i, nearest, std::exp(ready.places[nearest]), probability});
    } else if (tones[same->tone].level < tone.level) {
      same->tone = i;
      same->probability = probability;
    }
  }
  return matches;
}

double chance_of_match(std::span<const HeardTone> tones, std::span<const ModePitches> modes,
                       const PitchNuisance& best, const PitchPrior& prior) {
  check(modes);
  std::vector<PreparedModes> sets = {
      prepared(pitches_at(modes, best.poisson_ratio), best.sharpness)};
  for (std::size_t i = 0; modes.size() > 1 && i < modes.size(); ++i) {
    sets.push_back(prepared(modes[i], best.sharpness));
  }
  const double scatter = std::clamp(best.scatter, chance_scatters.low, chance_scatters.high);
  const auto score = [&](std::span<const HeardTone> heard) {
    const std::vector<double> evidence =
        coarse_evidence(heard, sets, 2.5 * scatter * cent, {&scatter, 1}, prior);
    return *std::max_element(evidence.begin(), evidence.end());
  };
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < random_moves; ++i) {
    core::RandomStream random(1, static_cast<std::uint64_t>(i), "material.chance");
    std::vector<HeardTone> moved(tones.begin(), tones.end());
    for (HeardTone& tone : moved) tone.log_frequency += random_move * random.normal();
    const double value = score(moved);
    sum += value;
    squares += value * value;
  }
  const double mean = sum / random_moves;
  const double deviation = std::sqrt(std::max(1e-6, (squares - sum * mean) / (random_moves - 1)));
  const double scale = deviation * std::sqrt(6.0) / std::numbers::pi;
  const double place = mean - std::numbers::egamma * scale;
  return -std::expm1(-std::exp(-(score(tones) - place) / scale));
}

}  // namespace carillon::eval::material
