#include "eval/recorded_objects/impact_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace carillon::eval::recorded_objects {

namespace {

/// Between moduli of one strike and of all: ten times what a good recording scatters.
constexpr double disagrees = 0.02;
/// Twice and six times what a single recording of a known level is fitted with (hybrid_metric.hpp).
constexpr double level_scale = 20, min_difference = 0.3;
/// A fit has so many times the pairs of chance within a quarter of the widest distance.
constexpr double beyond_chance = 1.5, near_limit = 0.25;

/// What of a candidate of an object is heard in the band of one strike.
material::HeardCandidate heard(const material::StruckModes& modes, double specific_modulus,
                               const synth::damping::DampingModel& damping,
                               const StudyOptions& options) {
  const material::Candidate candidate{
      .specific_modulus = specific_modulus, .scale = 1, .contact_time = 0, .damping = damping};
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

/// An object with one damping model, whose frequencies are scaled strike by strike.
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
    tones.push_back({strikes[i].set.features,
                     heard(struck_by(object, model, i),
                           object.specific_modulus * factors[i] * factors[i], damping, options)
                         .tones});
  }
  recorded::RecordedOptions how;
  how.modes.widest = options.widest;
  how.modes.from = options.skip;
  how.min_level = options.min_level;
  variant.modes = recorded::compare_recorded(tones, how);
  const auto scaled = [](double factor) { return factor != 1; };
  if (object.pressure && std::any_of(factors.begin(), factors.end(), scaled)) {
    variant.frequencies_alone = true;
    leave_frequencies(variant.modes);
  }
  return variant;
}

/// Decay rate by radiation of the mode nearest to a frequency [1/s].
double radiated_near(const HeardObject& object, double frequency) {
  if (object.radiated.empty()) return 0;
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < object.modes.size(); ++i) {
    if (std::abs(object.modes.frequency(i) - frequency) <
        std::abs(object.modes.frequency(nearest) - frequency)) {
      nearest = i;
    }
  }
  return object.radiated[nearest];
}

/// Damping of the material at the recorded modes that have a partner.
damping::DampingData matched_damping(const std::vector<StudiedStrike>& strikes,
                                     const HeardObject& object,
                                     const recorded::RecordedComparison& comparison,
                                     std::size_t& radiating) {
  damping::DampingData data;
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    for (const perception::MatchedMode& pair : comparison.strikes[i].matched) {
      const features::Feature& mode = strikes[i].set.features[pair.reference];
      const features::Feature& partner = comparison.synthetic[i][pair.other];
      const double rate = mode.decay_rate - radiated_near(object, partner.frequency);
      if (mode.reverberant || !(rate > 0)) {
        ++radiating;
        continue;
      }
      data.eigenvalues.push_back(features::eigenvalue(mode));
      data.coefficients.push_back(2 * rate);
    }
  }
  return data;
}

/// What a user should know of the modulus that was found.
void remark_on_modulus(const std::vector<StudiedStrike>& strikes, const HeardObject& fitted,
                       StudyFit& fit) {
  const double modulus = fitted.specific_modulus;
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    const auto& alone = fit.joint.alone[i];
    if (!alone) continue;
    const double ratio = alone->candidate.specific_modulus / modulus;
    if (std::abs(std::log(ratio)) < disagrees) continue;
    fit.remarks.push_back(
        fmt::format("vertex {} alone would have a specific modulus {:.3f} times that of all",
                    strikes[i].recorded.vertex, ratio));
  }
  const double known = fitted.modes.certificate.complete_to_hz;
  std::size_t above = 0;
  for (const StudiedStrike& strike : strikes) {
    for (const features::Feature& mode : strike.set.features)
      above += mode.frequency > known ? 1U : 0U;
  }
  if (above > 0) {
    fit.remarks.push_back(
        fmt::format("modes of the fitted material are known up to {:.0f} Hz, and {} recorded "
                    "mode{} above: raise --max-frequency",
                    known, above, above == 1 ? " lies" : "s lie"));
  }
}

/// Whether chance would have matched as many modes as closely.
void remark_on_chance(const std::vector<StudiedStrike>& strikes,
                      const recorded::RecordedComparison& comparison, double widest,
                      StudyFit& fit) {
  const auto frequencies = [](const std::vector<features::Feature>& tones) {
    std::vector<double> all;
    for (const features::Feature& tone : tones) all.push_back(tone.frequency);
    return all;
  };
  std::size_t near = 0;
  double chance = 0;
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    for (const perception::MatchedMode& pair : comparison.strikes[i].matched) {
      near += std::abs(pair.cents) <= near_limit * widest ? 1U : 0U;
    }
    chance += recorded::pairs_by_chance(frequencies(comparison.synthetic[i]),
                                        frequencies(strikes[i].set.features), near_limit * widest);
  }
  if (static_cast<double>(near) >= beyond_chance * chance) return;
  fit.remarks.push_back(
      fmt::format("the fit is not to be trusted: {} modes match within {:.3g} cents, and chance "
                  "makes {:.1f} such pairs",
                  near, near_limit * widest, chance));
}

/// @throws InputError  nothing to compare; as features::extract_features()
StudiedStrike study_strike(const ImpactFolder& folder, const RecordedStrike& strike, double onset,
                           const StudyOptions& options) {
  StudiedStrike studied;
  studied.recorded = strike;
  studied.samples = read_recording(folder, strike.row);
  features::FeatureOptions features;
  features.onset = onset;
  features.contact_time = options.skip;
  features.min_frequency = options.min_frequency;
  features.max_frequency = options.max_frequency;
  features.min_level = options.min_level;
  studied.set = features::extract_features(studied.samples, options.sample_rate, features);
  studied.spectrum =
      recorded::window_spectrum(studied.samples, options.sample_rate, options.stretch);
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
      strikes.push_back(study_strike(folder, rows[i], arrival(given, model, i), options));
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

StudyFit fit_material(const std::vector<StudiedStrike>& strikes,
                      const std::vector<ModelStrike>& model, const HeardObject& given,
                      HeardObject& fitted, const StudyOptions& options,
                      const std::filesystem::path& cache) {
  material::MaterialOptions material;
  material.law = options.law;
  material.motion = material::HeardMotion::acceleration;
  material.contact_time = 0;  // the hammer's force is deconvolved
  material.starts.min_modulus = given.specific_modulus / options.modulus_range;
  material.starts.max_modulus = given.specific_modulus * options.modulus_range;
  // Microphones, the mesh and a strike that is not quite straight change levels: they count for
  // less.
  material.metric.match.level = level_scale;
  material.metric.min_difference = min_difference;
  StudyFit fit;
  fitted = given;
  // What is radiated depends on the modulus that is sought: the second round knows it.
  for (int round = 0; round < 2; ++round) {
    std::vector<material::StruckRecording> recordings;
    for (std::size_t i = 0; i < strikes.size(); ++i) {
      recordings.push_back({strikes[i].samples, &strikes[i].set, struck_by(fitted, model, i)});
    }
    fit.joint = material::estimate_jointly(recordings, material);
    const double found = fit.joint.candidate.specific_modulus;
    const bool settled = std::abs(std::log(found / fitted.specific_modulus)) < 0.01;
    fitted =
        hear_object(given.modes, given.specific_modulus, found, model, options.radiation, cache);
    if (settled || !options.radiation) break;
  }
  fit.remarks = fit.joint.remarks;
  remark_on_modulus(strikes, fitted, fit);

  fit.damping = fit.joint.candidate.damping;
  const std::vector<double> ones(strikes.size(), 1.0);
  const ModelVariant matched = make_variant("", strikes, model, fitted, fit.damping, ones, options);
  remark_on_chance(strikes, matched.modes, options.widest, fit);
  std::size_t radiating = 0;
  const damping::DampingData data = matched_damping(strikes, fitted, matched.modes, radiating);
  if (radiating > 0) {
    fit.remarks.push_back(fmt::format(
        "{} matched mode{} no faster than the model radiates: left out of the damping's fit",
        radiating, radiating == 1 ? " decays" : "s decay"));
  }
  try {
    const damping::DampingFit law =
        damping::fit_damping(data, options.law, {.estimator = options.estimator});
    fit.damping = law.model;
    fit.confidence95 = law.confidence95;
    fit.points = data.size();
    fit.remarks.insert(fit.remarks.end(), law.remarks.begin(), law.remarks.end());
  } catch (const core::InputError& error) {
    fit.remarks.push_back("damping as the joint estimate has it: " + error.message());
  }
  return fit;
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
  if (fit != nullptr) {
    variants.push_back(
        make_variant("fitted", strikes, model, *fitted, fit->damping, ones, options));
    const double factor = std::sqrt(fitted->specific_modulus / given.specific_modulus);
    variants.back().scales.assign(strikes.size(), factor);
  }
  return variants;
}

}  // namespace carillon::eval::recorded_objects
