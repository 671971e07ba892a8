#include "eval/recorded/peak_match.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/perception/assignment.hpp"

namespace carillon::eval::recorded {

namespace {

/// Intervals all modes are moved by for the number of pairs that chance makes [cents]: on both
/// sides, beyond what a wrong modulus or a neighbour of a pair could make of a true match.
constexpr double nearest_shift = 200, farthest_shift = 600, shift_step = 25;

void check(std::span<const double> modes, std::span<const double> peaks, double widest) {
  const auto positive = [](double frequency) {
    if (frequency > 0 && std::isfinite(frequency)) return;
    throw core::InputError(fmt::format("{} Hz cannot be compared with a peak", frequency));
  };
  for (const double mode : modes) positive(mode);
  for (const double peak : peaks) positive(peak);
  if (!(widest > 0)) throw core::InputError("the distance of a pair must be positive");
}

/// Pairs of most modes with nearby peaks, nearest first where there is a choice.
std::vector<double> pairs(std::span<const double> modes, std::span<const double> peaks,
                          double widest, double factor) {
  std::vector<double> gains(modes.size() * peaks.size(), 0.0);
  std::vector<double> apart(gains.size());
  for (std::size_t i = 0; i < modes.size(); ++i) {
    for (std::size_t j = 0; j < peaks.size(); ++j) {
      const std::size_t at = i * peaks.size() + j;
      apart[at] = core::cents(factor * modes[i] / peaks[j]);
      if (std::abs(apart[at]) <= widest) gains[at] = 2 - std::abs(apart[at]) / widest;
    }
  }
  const auto partners = perception::best_pairs(gains, modes.size(), peaks.size());
  std::vector<double> cents;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (partners[i] != perception::unpaired) cents.push_back(apart[i * peaks.size() + partners[i]]);
  }
  return cents;
}

}  // namespace

double pairs_by_chance(std::span<const double> modes, std::span<const double> others,
                       double widest) {
  check(modes, others, widest);
  double sum = 0;
  int shifts = 0;
  for (double shift = nearest_shift; shift <= farthest_shift; shift += shift_step) {
    for (const double side : {-1.0, 1.0}) {
      sum +=
          static_cast<double>(pairs(modes, others, widest, std::exp2(side * shift / 1200)).size());
      ++shifts;
    }
  }
  return sum / shifts;
}

PeakMatch match_peaks(std::span<const double> modes, std::span<const SpectralPeak> peaks,
                      double widest) {
  std::vector<double> frequencies;
  for (const SpectralPeak& peak : peaks) frequencies.push_back(peak.frequency);
  check(modes, frequencies, widest);
  PeakMatch match;
  match.modes = modes.size();
  match.peaks = peaks.size();
  const std::size_t both = std::min(modes.size(), peaks.size());
  double hertz = 0, cents = 0;
  for (std::size_t i = 0; i < both; ++i) {
    hertz += std::pow(modes[i] - frequencies[i], 2);
    cents += std::pow(core::cents(modes[i] / frequencies[i]), 2);
  }
  // 0 / 0 for none.
  match.rank_rms_hz = std::sqrt(hertz / static_cast<double>(both));
  match.rank_rms_cents = std::sqrt(cents / static_cast<double>(both));
  match.cents = pairs(modes, frequencies, widest, 1);
  match.matched = match.cents.size();
  match.matched_by_chance = pairs_by_chance(modes, frequencies, widest);
  return match;
}

PeakMatch joined(std::span<const PeakMatch> matches) {
  PeakMatch all;
  double hertz = 0, cents = 0, ranks = 0;
  for (const PeakMatch& match : matches) {
    all.modes += match.modes;
    all.peaks += match.peaks;
    all.matched += match.matched;
    all.matched_by_chance += match.matched_by_chance;
    all.cents.insert(all.cents.end(), match.cents.begin(), match.cents.end());
    const auto both = static_cast<double>(std::min(match.modes, match.peaks));
    if (both == 0) continue;
    ranks += both;
    hertz += both * match.rank_rms_hz * match.rank_rms_hz;
    cents += both * match.rank_rms_cents * match.rank_rms_cents;
  }
  all.rank_rms_hz = std::sqrt(hertz / ranks);
  all.rank_rms_cents = std::sqrt(cents / ranks);
  return all;
}

double scale_frequency(std::span<const SpectralPeak> peaks, ScalePeak choice) {
  std::vector<SpectralPeak> sorted(peaks.begin(), peaks.end());
  if (sorted.empty()) throw core::InputError("the recording's spectrum has no peak");
  std::stable_sort(sorted.begin(), sorted.end(), [](const SpectralPeak& a, const SpectralPeak& b) {
    return a.amplitude > b.amplitude;
  });
  if (choice == ScalePeak::highest) return sorted.front().frequency;
  sorted.resize(std::min<std::size_t>(10, sorted.size()));
  const auto lowest = std::min_element(
      sorted.begin(), sorted.end(),
      [](const SpectralPeak& a, const auto& b) { return a.frequency < b.frequency; });
  return lowest->frequency;
}

}  // namespace carillon::eval::recorded
