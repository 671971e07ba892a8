#include "eval/features/read_clip.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace carillon::eval::features {

namespace {

constexpr double same_mode = 3;  ///< standard errors
/// Of the half width of a line: channels hear a mode this alike only, with whatever else they hear.
constexpr double min_error = 0.05;
constexpr double same_hum = 0.5;  ///< [Hz]

/// Distance of two features in standard errors of their difference; without errors, in half widths
/// of their lines.
double distance(const Feature& a, const Feature& b) {
  const auto apart = [](double x, double y, double ex, double ey, double width) {
    const double error = std::hypot(ex, ey);
    const bool known = std::isfinite(error) && error > 0;
    return std::abs(x - y) / (known ? std::max(error, min_error * width) : width);
  };
  const double width = 0.5 * (a.decay_rate + b.decay_rate);
  return std::max(apart(a.frequency, b.frequency, a.frequency_error, b.frequency_error,
                        width / (2 * std::numbers::pi)),
                  apart(a.decay_rate, b.decay_rate, a.decay_rate_error, b.decay_rate_error, width));
}

/// Mean of two values weighted by their errors, and its error.
void join(double& value, double& error, double other, double other_error) {
  if (!std::isfinite(error) || !std::isfinite(other_error) || !(error > 0) || !(other_error > 0)) {
    return;
  }
  const double own = 1 / (error * error), its = 1 / (other_error * other_error);
  value = (own * value + its * other) / (own + its);
  error = 1 / std::sqrt(own + its);
}

Feature joined(const Feature& a, const Feature& b) {
  Feature feature = a.amplitude >= b.amplitude ? a : b;
  const Feature& other = a.amplitude >= b.amplitude ? b : a;
  join(feature.frequency, feature.frequency_error, other.frequency, other.frequency_error);
  join(feature.decay_rate, feature.decay_rate_error, other.decay_rate, other.decay_rate_error);
  feature.snr = std::max(a.snr, b.snr);
  return feature;
}

double energy(std::span<const double> samples) {
  double sum = 0;
  for (const double sample : samples) sum += sample * sample;
  return sum;
}

}  // namespace

FeatureSet merge_channels(std::vector<FeatureSet> channels) {
  FeatureSet set = std::move(channels.front());
  for (std::size_t c = 1; c < channels.size(); ++c) {
    const std::vector<Feature>& others = channels[c].features;
    struct Match {
      double distance;
      std::size_t own, other;
    };
    std::vector<Match> matches;
    for (std::size_t i = 0; i < set.features.size(); ++i) {
      for (std::size_t k = 0; k < others.size(); ++k) {
        const double apart = distance(set.features[i], others[k]);
        if (apart <= same_mode) matches.push_back({apart, i, k});
      }
    }
    // The most alike first; each is one mode.
    std::stable_sort(matches.begin(), matches.end(),
                     [](const Match& a, const Match& b) { return a.distance < b.distance; });
    std::vector<bool> joined_own(set.features.size(), false), joined_other(others.size(), false);
    for (const Match& match : matches) {
      if (joined_own[match.own] || joined_other[match.other]) continue;
      set.features[match.own] = joined(set.features[match.own], others[match.other]);
      joined_own[match.own] = joined_other[match.other] = true;
    }
    for (std::size_t k = 0; k < others.size(); ++k) {
      if (!joined_other[k]) set.features.push_back(others[k]);
    }
    for (const Hum& hum : channels[c].hums) {
      const bool known = std::any_of(set.hums.begin(), set.hums.end(), [&](const Hum& other) {
        return std::abs(other.frequency - hum.frequency) < same_hum;
      });
      if (!known) set.hums.push_back(hum);
    }
    for (std::string& remark : channels[c].remarks) set.remarks.push_back(std::move(remark));
    set.clipped += channels[c].clipped;
  }
  if (!set.features.empty()) set.nothing.clear();
  const auto by_frequency = [](const auto& a, const auto& b) { return a.frequency < b.frequency; };
  std::sort(set.features.begin(), set.features.end(), by_frequency);
  std::sort(set.hums.begin(), set.hums.end(), by_frequency);
  return set;
}

std::vector<ClipChannel> channels_by_energy(const core::AudioClip& clip) {
  const auto width = static_cast<std::size_t>(clip.channels);
  std::vector<ClipChannel> channels;
  for (std::size_t c = 0; c < width; ++c) {
    ClipChannel channel{c, {}};
    channel.samples.reserve(clip.samples.size() / width);
    for (std::size_t n = c; n < clip.samples.size(); n += width) {
      channel.samples.push_back(clip.samples[n]);
    }
    const auto same = [&](const ClipChannel& other) { return other.samples == channel.samples; };
    if (std::any_of(channels.begin(), channels.end(), same)) continue;
    channels.push_back(std::move(channel));
  }
  std::stable_sort(channels.begin(), channels.end(),
                   [](const ClipChannel& a, const ClipChannel& b) {
                     return energy(a.samples) > energy(b.samples);
                   });
  return channels;
}

FeatureSet read_features(const std::filesystem::path& path, const FeatureOptions& options) {
  const core::AudioClip clip = core::read_audio(path);
  // The loudest first: where it begins and ends counts for all.
  const std::vector<ClipChannel> channels = channels_by_energy(clip);
  std::vector<FeatureSet> sets;
  for (const ClipChannel& channel : channels) {
    FeatureOptions own = options;
    if (!sets.empty() && !own.onset && sets.front().nothing.empty()) own.onset = sets.front().onset;
    try {
      sets.push_back(extract_features(channel.samples, clip.sample_rate, own));
    } catch (const core::InputError& error) {
      const std::string place =
          clip.channels > 1 ? fmt::format("{}: channel {}", path.string(), channel.number + 1)
                            : path.string();
      throw core::InputError(fmt::format("{}: {}", place, error.message()), error.hint());
    }
    for (Feature& feature : sets.back().features) {
      feature.channel = static_cast<int>(channel.number);
    }
    if (channels.size() == 1) continue;
    for (std::string& remark : sets.back().remarks) {
      remark = fmt::format("channel {}: {}", channel.number + 1, remark);
    }
  }
  if (sets.empty()) {
    FeatureSet empty;
    empty.sample_rate = clip.sample_rate;
    empty.nothing = "no samples";
    return empty;
  }
  return merge_channels(std::move(sets));
}

}  // namespace carillon::eval::features
