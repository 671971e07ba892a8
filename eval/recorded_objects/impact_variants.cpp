#include <algorithm>
#include <cmath>
#include <limits>

#include "eval/recorded_objects/impact_study.hpp"

namespace carillon::eval::recorded_objects {

namespace {

/// What of a candidate of an object is heard in the band of one strike.
material::HeardCandidate heard(const material::StruckModes& modes, double specific_modulus,
                               double contact_time, const synth::damping::DampingModel& damping,
                               const StudyOptions& options) {
  const material::Candidate candidate{.specific_modulus = specific_modulus,
                                      .scale = 1,
                                      .contact_time = contact_time,
                                      .damping = damping};
  return material::heard_candidate(modes, candidate, material::HeardMotion::acceleration,
                                   options.min_frequency, options.max_frequency);
}

/// Frequencies of the lowest modes, times a factor [Hz].
std::vector<double> lowest_modes(const solvers::modes::Modes& modes, std::size_t count,
                                 double factor) {
  std::vector<double> frequencies;
  for (std::size_t i = 0; i < std::min(count, modes.size()); ++i) {
    frequencies.push_back(factor * modes.frequency(i));
  }
  return frequencies;
}

/// Takes out of a comparison what was reckoned with the pressure at other frequencies.
void leave_frequencies(recorded::RecordedComparison& modes) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  for (perception::ModeComparison& strike : modes.strikes) {
    for (perception::MatchedMode& pair : strike.matched) pair.decay_ratio = pair.level = none;
  }
  for (std::vector<features::Feature>& tones : modes.synthetic) {
    for (features::Feature& tone : tones) tone.decay_rate = tone.amplitude = none;
  }
  modes.gain = modes.all.synthetic_fraction = none;
  modes.all.decay_ratio = modes.all.level_error = {none, none, none};
}

}  // namespace

ModelVariant make_variant(const std::string& name, const std::vector<StudiedStrike>& strikes,
                          const std::vector<ModelStrike>& model, const HeardObject& object,
                          const synth::damping::DampingModel& damping,
                          const std::vector<double>& factors, const StudyOptions& options) {
  ModelVariant variant{
      .name = name, .frequencies_alone = false, .scales = factors, .peaks = {}, .modes = {}};
  std::vector<recorded::RecordedTones> tones;
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    const auto frequencies = lowest_modes(object.modes, options.peaks, factors[i]);
    std::vector<recorded::SpectralPeak> peaks =
        recorded::highest_peaks(strikes[i].spectrum, frequencies.size(), options.min_frequency);
    variant.peaks.push_back(recorded::match_peaks(frequencies, peaks, options.widest));
    tones.push_back(
        {strikes[i].set.features,
         heard(struck_by(object, model, i), object.specific_modulus * factors[i] * factors[i],
               model[i].contact_time, damping, options)
             .tones});
  }
  recorded::RecordedOptions how;
  how.modes.widest = options.widest;
  // After the longest contact all modes are free.
  double contact = 0;
  for (const ModelStrike& strike : model) contact = std::max(contact, strike.contact_time);
  how.modes.from = options.skip + contact;
  how.min_level = options.min_level;
  variant.modes = recorded::compare_recorded(tones, how);
  const auto scaled = [](double factor) { return factor != 1; };
  if (object.pressure && std::any_of(factors.begin(), factors.end(), scaled)) {
    variant.frequencies_alone = true;
    leave_frequencies(variant.modes);
  }
  return variant;
}

std::vector<ModelVariant> compare_variants(const std::vector<StudiedStrike>& strikes,
                                           const std::vector<ModelStrike>& model,
                                           const HeardObject& given,
                                           const synth::damping::DampingModel& damping,
                                           const HeardObject* fitted, const StudyFit* fit,
                                           const StudyOptions& options) {
  const std::vector<double> ones(strikes.size(), 1.0);
  std::vector<ModelVariant> variants = {
      make_variant("as given", strikes, model, given, damping, ones, options)};
  for (const auto& [name, choice] :
       {std::pair("scaled to the highest peak", recorded::ScalePeak::highest),
        std::pair("scaled to the lowest of ten", recorded::ScalePeak::lowest_of_ten)}) {
    std::vector<double> factors;
    for (const StudiedStrike& strike : strikes) {
      factors.push_back(recorded::scale_frequency(strike.peaks, choice) / given.modes.frequency(0));
    }
    variants.push_back(make_variant(name, strikes, model, given, damping, factors, options));
  }
  if (fitted != nullptr) {
    variants.push_back(
        make_variant("fitted", strikes, model, *fitted, fit->damping, ones, options));
    const double factor = std::sqrt(fitted->specific_modulus / given.specific_modulus);
    variants.back().scales.assign(strikes.size(), factor);
  }
  return variants;
}

}  // namespace carillon::eval::recorded_objects
