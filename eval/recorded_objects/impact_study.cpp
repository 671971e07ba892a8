#include "eval/recorded_objects/impact_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "eval/recorded_objects/impact_contact.hpp"

namespace carillon::eval::recorded_objects {

namespace {

/// When the hammer touches and for how long, as far as that is known before the sound is.
struct KnownContact {
  std::optional<double> touch;  ///< [s] from the first sample
  double duration = 0;          ///< [s]; 0: an ideal impulse
};

KnownContact known_contact(const ImpactFolder& folder, std::size_t row,
                           const StudyOptions& options) {
  if (folder.deconvolved) return {0.0, options.contact_time.value_or(0)};
  const std::vector<double> force = read_force(folder, row);
  if (force.empty()) return {{}, options.contact_time.value_or(0)};
  const ImpactContact contact = contact_of(force, options.sample_rate);
  return {contact.begin, options.contact_time.value_or(contact.duration)};
}

/// @param delay  of the first sound after the touch [s]
/// @param model  gets the contact time
/// @throws InputError  nothing to compare; as features::extract_features()
StudiedStrike study_strike(const ImpactFolder& folder, const RecordedStrike& strike, double delay,
                           const StudyOptions& options, ModelStrike& model) {
  const KnownContact contact = known_contact(folder, strike.row, options);
  model.contact_time = contact.duration;
  StudiedStrike studied;
  studied.recorded = strike;
  studied.samples = read_recording(folder, strike.row);
  features::FeatureOptions features;
  if (contact.touch) features.onset = *contact.touch + delay;
  features.contact_time = options.skip + contact.duration;
  features.min_frequency = options.min_frequency;
  features.max_frequency = options.max_frequency;
  features.min_level = options.min_level;
  studied.set = features::extract_features(studied.samples, options.sample_rate, features);
  studied.touch = contact.touch.value_or(std::max(0.0, studied.set.onset - delay));
  const auto shift = static_cast<std::size_t>(std::lround(studied.touch * options.sample_rate));
  studied.spectrum =
      recorded::window_spectrum(studied.samples, options.sample_rate,
                                {options.stretch.first + shift, options.stretch.end + shift});
  studied.peaks = recorded::highest_peaks(studied.spectrum, options.peaks, options.min_frequency);
  if (studied.peaks.empty()) {
    throw core::InputError(
        fmt::format("row {} of {} is silent", strike.row, folder.recordings.path().string()));
  }
  return studied;
}

}  // namespace

std::vector<StudiedStrike> study_strikes(const ImpactFolder& folder,
                                         const std::vector<RecordedStrike>& rows,
                                         const StudyOptions& options,
                                         std::vector<ModelStrike>& model, HeardObject& given,
                                         std::vector<std::string>& remarks) {
  std::vector<StudiedStrike> strikes;
  std::vector<std::size_t> kept;
  std::string why = "there are none";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    try {
      strikes.push_back(study_strike(folder, rows[i], arrival(given, model, i), options, model[i]));
      kept.push_back(i);
    } catch (const core::InputError& error) {
      why = error.message();
      remarks.push_back(fmt::format("vertex {} is left out: {}", rows[i].vertex, why));
    }
  }
  if (strikes.empty()) {
    throw core::InputError("no recording can be compared: " + why,
                           "name other vertices with --vertex, or another microphone with "
                           "--listener");
  }
  keep_strikes(kept, model, given);
  return strikes;
}

}  // namespace carillon::eval::recorded_objects
