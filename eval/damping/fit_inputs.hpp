#pragma once

#include <string>
#include <vector>

#include "eval/damping/damping_data.hpp"
#include "eval/features/extract_features.hpp"

namespace carillon::eval::damping {

/// What a fit is made of: files in the order given.
struct FitSource {
  std::string name;
  std::vector<features::Feature> features;
  std::string nothing;               ///< why there are no features; "" where there are
  std::vector<std::string> remarks;  ///< of what was left out
  std::vector<double> rt60;          ///< of the room, by octave [s]; empty: none is known
  bool by_room = false;              ///< features are those of reverberant_modes()
};

/// One recording; of a room whose reverberation time is given, the modes that its loudest channel
/// shows (reverberant_modes()), unless the papers' peaks are asked for. What cannot be read or
/// analysed has no features and says why.
FitSource fit_source_of_recording(const std::string& path, const features::FeatureOptions& options);

/// One table of features; one without lines says so. What decays faster than a room of the given
/// times is left out of it.
/// @throws FileError, InputError  as read_feature_table()
FitSource fit_source_of_table(const std::string& path, const std::vector<double>& rt60 = {});

/// What a law is fitted to.
DampingData fitted_data(const std::vector<FitSource>& sources);

/// Features of all sources together; their errors only where all are known.
std::vector<features::Feature> joined_features(const std::vector<FitSource>& sources);

}  // namespace carillon::eval::damping
