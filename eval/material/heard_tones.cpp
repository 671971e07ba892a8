#include "eval/material/heard_tones.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/numbers.hpp"

namespace carillon::eval::material {

namespace {

constexpr double one_cent = std::numbers::ln2 / 1200;
/// Half the width of a tone: doublets of real objects lie within it [logarithm of frequency]. The
/// skirts of a strong one, where a room or a beat leaves companions, are wider for weaker features.
constexpr double half_width = 20 * one_cent;
constexpr double skirt = 1.5 * one_cent;  // more for every dB
constexpr double widest_skirt = 80 * one_cent;
constexpr double weakest = -45;  // [dB]
constexpr std::size_t most_tones = 60;
constexpr double certain = 0.9;          // of the strongest tone
constexpr double certainty_decade = 50;  // over so many dB certainty falls to a tenth
constexpr double of_room = 0.25;         // of what may be the room's
/// Share of half a line's width by which beats and companions may shift it.
constexpr double of_width = 0.1;

/// How far features stand out [dB].
std::vector<double> levels_of(std::span<const features::Feature> features) {
  std::vector<double> levels;
  for (const features::Feature& feature : features) levels.push_back(feature.snr);
  const bool known = std::all_of(levels.begin(), levels.end(),
                                 [](double level) { return std::isfinite(level) && level > 0; });
  if (known) return levels;
  // Extracted by a method that does not say, or made: their energy.
  for (std::size_t i = 0; i < features.size(); ++i) {
    const double energy = features[i].amplitude * features[i].amplitude / features[i].decay_rate;
    levels[i] = core::decibels(std::max(energy, 1e-300));
  }
  return levels;
}

HeardTone tone_of(const features::Feature& feature, double level, FeatureIndex index) {
  const double width = feature.decay_rate / (2 * std::numbers::pi * feature.frequency);
  const double error =
      std::isfinite(feature.frequency_error) ? feature.frequency_error / feature.frequency : 0;
  HeardTone tone;
  tone.log_frequency =
      0.5 * std::log(features::eigenvalue(feature)) - std::log(2 * std::numbers::pi);
  tone.error = std::hypot(error, of_width * width);
  tone.level = level;
  tone.certainty =
      certain * std::pow(10, level / certainty_decade) * (feature.reverberant ? of_room : 1);
  tone.heads = {index};
  return tone;
}

/// Adds the tones of one recording to those that are there.
void add_tones(std::vector<HeardTone>& tones, const features::FeatureSet& set,
               std::size_t recording) {
  const std::vector<double> levels = levels_of(set.features);
  std::vector<std::size_t> order(levels.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return levels[a] > levels[b]; });
  std::vector<HeardTone> own;
  for (const std::size_t index : order) {
    const double level = levels[index] - levels[order.front()];
    if (level < weakest) break;
    const HeardTone tone = tone_of(set.features[index], level, {recording, index});
    const bool again = std::any_of(own.begin(), own.end(), [&](const HeardTone& other) {
      const double width = half_width + skirt * (other.level - level);
      return std::abs(other.log_frequency - tone.log_frequency) < std::min(width, widest_skirt);
    });
    if (!again) own.push_back(tone);
  }
  for (HeardTone& tone : own) {
    const auto same = std::find_if(tones.begin(), tones.end(), [&](const HeardTone& other) {
      return std::abs(other.log_frequency - tone.log_frequency) < half_width;
    });
    if (same == tones.end()) {
      tones.push_back(std::move(tone));
      continue;
    }
    std::vector<FeatureIndex> heads = same->heads;
    if (tone.level > same->level) {
      std::swap(*same, tone);
      heads.insert(heads.begin(), same->heads.front());
    } else {
      heads.push_back(tone.heads.front());
    }
    // What two recordings have is the less likely to be chance.
    same->certainty = 1 - (1 - same->certainty) * (1 - tone.certainty);
    same->heads = std::move(heads);
  }
}

}  // namespace

std::vector<HeardTone> heard_tones(std::span<const features::FeatureSet> recordings) {
  std::vector<HeardTone> tones;
  for (std::size_t r = 0; r < recordings.size(); ++r) add_tones(tones, recordings[r], r);
  std::stable_sort(tones.begin(), tones.end(), [](const HeardTone& a, const HeardTone& b) {
    return a.certainty > b.certainty;
  });
  tones.resize(std::min(tones.size(), most_tones));
  std::sort(tones.begin(), tones.end(), [](const HeardTone& a, const HeardTone& b) {
    return a.log_frequency < b.log_frequency;
  });
  return tones;
}

}  // namespace carillon::eval::material
