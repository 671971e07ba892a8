#include "eval/accuracy/feature_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/json.hpp"
#include "core/numbers.hpp"
#include "core/random.hpp"
#include "core/trace.hpp"
#include "eval/features/cramer_rao.hpp"
#include "eval/features/extract_features.hpp"

namespace carillon::eval::accuracy {

using features::Feature;
using nlohmann::ordered_json;

namespace {

/// Half of what a normal variable does lies within this many standard deviations.
constexpr double median_deviation = 0.6745;
/// A feature further from a mode is another one [of the mode's bound, and of its frequency].
constexpr double max_bounds = 50, max_shift = 2e-3;

struct Clip {
  std::vector<Feature> modes;
  std::vector<double> samples;
  double noise = 0;  ///< standard deviation
};

std::vector<Feature> draw_modes(int count, core::RandomStream& random) {
  constexpr double lowest = 200, span = 70;  // to 14 kHz
  std::vector<Feature> modes;
  for (int i = 0; i < count; ++i) {
    Feature mode;
    mode.frequency = lowest * std::pow(span, (i + random.uniform(0.2, 0.8)) / count);
    mode.decay_rate = random.uniform(3, 10) * (1 + mode.frequency / 7000);
    mode.amplitude = random.uniform(0.3, 1);
    mode.phase = random.uniform(0, 2 * std::numbers::pi);
    modes.push_back(mode);
  }
  return modes;
}

Clip draw_clip(const FeatureStudy& study, int count, double snr_db, int number) {
  core::RandomStream random(static_cast<std::uint64_t>(count), static_cast<std::uint64_t>(number),
                            fmt::format("feature study {}", snr_db));
  Clip clip{draw_modes(count, random), {}, 0};
  clip.samples.resize(static_cast<std::size_t>(study.seconds * study.sample_rate));
  for (std::size_t i = 0; i < clip.samples.size(); ++i) {
    const double t = static_cast<double>(i) / study.sample_rate;
    for (const Feature& mode : clip.modes) {
      clip.samples[i] += mode.amplitude * std::exp(-mode.decay_rate * t) *
                         std::cos(2 * std::numbers::pi * mode.frequency * t + mode.phase);
    }
  }
  const auto first =
      std::min(clip.samples.size(), static_cast<std::size_t>(study.sample_rate / 10));
  double power = 0;
  for (std::size_t i = 0; i < first; ++i) power += clip.samples[i] * clip.samples[i];
  clip.noise = std::sqrt(power / static_cast<double>(first) * std::pow(10, -snr_db / 10));
  for (double& sample : clip.samples) sample += clip.noise * random.normal();
  return clip;
}

/// What one combination of method, modes and noise came to.
struct Tally {
  std::vector<double> seconds, frequency, decay_rate;  ///< errors over bounds
  std::size_t modes = 0, found = 0, features = 0;
};

void add_errors(const Clip& clip, const features::FeatureSet& set, Tally& tally) {
  const std::vector<features::ModeBound> bounds = features::cramer_rao(
      clip.modes, {set.sample_rate, set.begin - set.onset, set.end - set.onset, clip.noise});
  tally.modes += clip.modes.size();
  tally.features += set.features.size();
  for (std::size_t i = 0; i < clip.modes.size(); ++i) {
    const Feature& mode = clip.modes[i];
    const auto distance = [&](const Feature& feature) {
      return std::abs(feature.frequency - mode.frequency);
    };
    const auto nearest = std::min_element(
        set.features.begin(), set.features.end(),
        [&](const Feature& a, const Feature& b) { return distance(a) < distance(b); });
    if (nearest == set.features.end() ||
        distance(*nearest) >
            std::max(max_bounds * bounds[i].frequency, max_shift * mode.frequency)) {
      continue;
    }
    ++tally.found;
    tally.frequency.push_back(distance(*nearest) / bounds[i].frequency);
    tally.decay_rate.push_back(std::abs(nearest->decay_rate - mode.decay_rate) /
                               bounds[i].decay_rate);
  }
}

FeatureFindings::RefinementLevel level(const FeatureStudy& study, const std::string& method,
                                       int modes, double snr_db) {
  Tally tally;
  features::FeatureOptions options;
  options.method =
      method == "peaks" ? features::FeatureMethod::peaks : features::FeatureMethod::esprit;
  options.onset = 0;
  for (int i = 0; i < study.clips; ++i) {
    const Clip clip = draw_clip(study, modes, snr_db, i);
    const double start = core::thread_cpu_seconds();
    const features::FeatureSet set =
        features::extract_features(clip.samples, study.sample_rate, options);
    tally.seconds.push_back(core::thread_cpu_seconds() - start);
    add_errors(clip, set, tally);
  }
  const double clips = study.clips;
  return {
      .method = method,
      .modes = modes,
      .snr_db = snr_db,
      .seconds = core::median(tally.seconds),
      .found = static_cast<double>(tally.found) / static_cast<double>(tally.modes),
      .extra = static_cast<double>(tally.features - std::min(tally.features, tally.found)) / clips,
      .bounds_frequency = core::median(tally.frequency) / median_deviation,
      .bounds_decay_rate = core::median(tally.decay_rate) / median_deviation};
}

}  // namespace

FeatureStudy read_feature_study(core::ConfigNode node) {
  FeatureStudy study;
  study.extractors = node.texts("extractors", std::vector<std::string>{"esprit", "peaks"});
  for (const std::string& method : study.extractors) {
    if (method != "esprit" && method != "peaks") {
      node.fail("extractors", fmt::format("no extractor \"{}\"", method),
                "there are esprit and peaks");
    }
  }
  for (const double count :
       node.quantities("mode_counts", core::Dimension::none, 0, std::vector<double>{5, 20, 60})) {
    if (count != std::floor(count) || count < 1 || count > 300) {
      node.fail("mode_counts", "must be whole numbers from 1 to 300");
    }
    study.mode_counts.push_back(static_cast<int>(count));
  }
  study.snr_db =
      node.quantities("snr_levels", core::Dimension::level, 0, std::vector<double>{60, 30});
  study.clips = static_cast<int>(node.integer("clips", 1, 10000, 5));
  study.seconds = node.positive("seconds", core::Dimension::time, 1);
  study.sample_rate = node.positive("sample_rate", core::Dimension::frequency, 44100);
  if (study.seconds < 0.1) node.fail("seconds", "a clip lasts 0.1 s at least");
  if (study.sample_rate < 30000) {
    node.fail("sample_rate", "modes reach 14 kHz: 30 kHz at least");
  }
  return study;
}

ordered_json to_json(const FeatureFindings& findings) {
  if (!findings.failure.empty()) return {{"failure", findings.failure}};
  ordered_json levels = ordered_json::array();
  for (const FeatureFindings::RefinementLevel& level : findings.levels) {
    levels.push_back({{"method", level.method},
                      {"modes", level.modes},
                      {"snr_db", level.snr_db},
                      {"seconds", level.seconds},
                      {"found", level.found},
                      {"extra", level.extra},
                      {"bounds_frequency", core::number_or_null(level.bounds_frequency)},
                      {"bounds_decay_rate", core::number_or_null(level.bounds_decay_rate)}});
  }
  return {{"clips", findings.clips}, {"seconds", findings.seconds}, {"levels", levels}};
}

void print(const FeatureFindings& findings) {
  if (!findings.failure.empty()) {
    fmt::print("\nfeatures: {}\n", findings.failure);
    return;
  }
  const auto bounds = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.3g}", value) : "-";
  };
  fmt::print(
      "\nfeatures, errors over the Cramer-Rao bound\n{:<8}{:>7}{:>8}{:>10}{:>8}{:>12}{:>12}\n",
      "method", "modes", "dB", "s", "found", "frequency", "decay rate");
  for (const FeatureFindings::RefinementLevel& level : findings.levels) {
    fmt::print("{:<8}{:>7}{:>8}{:>10.2g}{:>7.0f}%{:>12}{:>12}\n", level.method, level.modes,
               level.snr_db, level.seconds, 100 * level.found, bounds(level.bounds_frequency),
               bounds(level.bounds_decay_rate));
  }
}

FeatureFindings measure_features(const FeatureStudy& study) {
  FeatureFindings findings{.clips = study.clips, .seconds = study.seconds};
  for (const std::string& method : study.extractors) {
    for (const int modes : study.mode_counts) {
      for (const double snr_db : study.snr_db)
        findings.levels.push_back(level(study, method, modes, snr_db));
    }
  }
  return findings;
}

}  // namespace carillon::eval::accuracy
