#include "eval/damping/fit_inputs.hpp"

#include "core/error.hpp"
#include "eval/damping/reverberant_modes.hpp"
#include "eval/features/feature_table.hpp"
#include "eval/features/read_clip.hpp"

namespace carillon::eval::damping {

namespace {

/// Of a room that is known, the modes that the loudest channel shows.
features::FeatureSet found_in(const std::string& path, const features::FeatureOptions& options,
                              bool by_room) {
  if (!by_room) return features::read_features(path, options);
  const core::AudioClip clip = core::read_audio(path);
  const auto channels = features::channels_by_energy(clip);
  return reverberant_modes(channels.front().samples, clip.sample_rate, options);
}

}  // namespace

FitSource fit_source_of_recording(const std::string& path,
                                  const features::FeatureOptions& options) {
  FitSource source{path, {}, "", {}, options.rt60};
  try {
    source.by_room =
        options.method == features::FeatureMethod::esprit && features::reverberates(options.rt60);
    features::FeatureSet found = found_in(path, options, source.by_room);
    source.features = std::move(found.features);
    source.remarks = std::move(found.remarks);
    if (source.features.empty()) {
      source.nothing = found.nothing.empty() ? "no decaying tone" : found.nothing;
    }
  } catch (const core::FileError& error) {
    source.nothing = error.message();
  } catch (const core::InputError& error) {
    source.nothing = error.message();
  }
  return source;
}

FitSource fit_source_of_table(const std::string& path, const std::vector<double>& rt60) {
  FitSource source{path, features::read_feature_table(path), "", {}, rt60};
  for (features::Feature& feature : source.features) {
    if (rt60.empty()) break;
    feature.reverberant =
        feature.reverberant || 2 * feature.decay_rate >= room_ceiling(rt60, feature.frequency);
  }
  if (source.features.empty()) source.nothing = "the table has no lines";
  return source;
}

DampingData fitted_data(const std::vector<FitSource>& sources) {
  std::vector<DampingData> parts;
  for (const FitSource& source : sources) {
    parts.push_back(source.by_room ? reverberant_data(source.features)
                                   : damping_data(source.features, source.rt60));
  }
  return joined(parts);
}

std::vector<features::Feature> joined_features(const std::vector<FitSource>& sources) {
  std::vector<features::Feature> features;
  for (const FitSource& source : sources) {
    features.insert(features.end(), source.features.begin(), source.features.end());
  }
  return features;
}

}  // namespace carillon::eval::damping
