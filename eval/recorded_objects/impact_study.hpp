#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/numbers.hpp"
#include "eval/features/extract_features.hpp"
#include "eval/material/joint_estimate.hpp"
#include "eval/recorded/compare_recorded.hpp"
#include "eval/recorded/peak_match.hpp"
#include "eval/recorded_objects/heard_object.hpp"
#include "eval/recorded_objects/listener_choice.hpp"
#include "synth/material/material.hpp"

namespace carillon::eval::recorded_objects {

/// What a material is found by.
enum class StudyMetric {
  pitches,  ///< the likelihood of the frequencies alone (pitch_posterior.hpp)
  hybrid    ///< the papers': spectrograms and match ratios (hybrid_metric.hpp)
};

/// How recordings and model are compared.
struct StudyOptions {
  double sample_rate = 48000;  ///< [Hz]
  recorded::Stretch stretch;   ///< of Hiner's spectra, in samples of the recordings
  std::size_t peaks = 30;      ///< modes, against as many of the highest peaks
  double widest = 100;         ///< further apart a mode is another one [cents]
  double min_level = -60;      ///< of modes, in energy against the strongest's [dB]
  double skip = 1e-3;          ///< left out after the first sound has come, by modal features [s]
  double min_frequency = 20;   ///< of peaks and modal features [Hz]
  double max_frequency = 20000;
  /// The fitted specific modulus lies within this factor of the one given: an object whose modes
  /// lie densely fits wrong ones, too.
  double modulus_range = 3;
  bool radiation = true;
  /// Of the hammer [s]; none: as its recorded force says, else an ideal impulse.
  std::optional<double> contact_time;
  StudyMetric metric = StudyMetric::pitches;
  damping::DampingLaw law;                      ///< of the fit
  std::optional<damping::Estimator> estimator;  ///< of the damping; none: fit_matched()'s
};

/// One recording and what is taken from it.
struct StudiedStrike {
  RecordedStrike recorded;
  std::vector<double> samples;
  double touch = 0;  ///< when the hammer touches [s] from the first sample
  features::FeatureSet set;
  recorded::WindowSpectrum spectrum;
  std::vector<recorded::SpectralPeak> peaks;
};

/// The model with one set of parameters, beside all recordings.
struct ModelVariant {
  std::string name;
  /// Levels, decay rates and the gain are not known (NaN): pressure and what is radiated go with
  /// the frequencies, and are those of other ones.
  bool frequencies_alone = false;
  std::vector<double> scales;  ///< of each strike's mode frequencies against those given
  std::vector<recorded::PeakMatch> peaks;  ///< of each strike
  recorded::RecordedComparison modes;
};

/// What the fit comes to. Without a specific modulus the recordings do not determine one, and there
/// is no damping.
struct StudyFit {
  std::optional<double> specific_modulus;    ///< E / density [m^2/s^2]
  std::optional<core::Range> modulus95;      ///< [m^2/s^2], by pitches
  std::string undetermined;                  ///< why there is none
  std::vector<std::optional<double>> alone;  ///< moduli that single recordings would have
  /// Log-likelihoods of the recorded pitches over that of chance (pitch_posterior.hpp): with the
  /// modulus found, and with the one given.
  double log_likelihood = 0, log_likelihood_given = 0;
  synth::damping::DampingModel damping;  ///< of the material, without what is radiated
  std::size_t points = 0;  ///< matched modes that the damping was fitted to; 0: it was not
  std::vector<core::Range> confidence95;  ///< of the damping's numbers, as those modes bound them
  std::optional<material::JointEstimate> joint;  ///< by the hybrid metric
  std::vector<std::string> remarks;
};

/// What the recordings hold. One that holds nothing to compare (a sample that is not finite,
/// silence) is left out, of `model` and `given` too.
/// @param rows     one for each strike of `model`, which get the contact times of their recordings
/// @param remarks  get a line for each recording that is left out
/// @throws InputError  none is left; says why
std::vector<StudiedStrike> study_strikes(const ImpactFolder& folder,
                                         const std::vector<RecordedStrike>& rows,
                                         const StudyOptions& options,
                                         std::vector<ModelStrike>& model, HeardObject& given,
                                         std::vector<std::string>& remarks);

/// Specific modulus and damping from all strikes. A fit that explains the recorded pitches worse
/// than the material given is not determined, whatever the metric says; damping that is further
/// from the recorded decay rates than the one given is not taken.
/// @param given     the object with the material it is taken to be of
/// @param material  that one
/// @param fitted    becomes the object with the specific modulus found; none: it is not determined
/// @throws InputError  no recording that a material can be estimated from
StudyFit fit_material(const std::vector<StudiedStrike>& strikes,
                      const std::vector<ModelStrike>& model, const HeardObject& given,
                      const synth::material::Material& material, std::optional<HeardObject>& fitted,
                      const StudyOptions& options, const std::filesystem::path& cache);

/// An object with one damping model beside the recordings, its frequencies scaled strike by strike.
/// @param factors  of each strike's frequencies
ModelVariant make_variant(const std::string& name, const std::vector<StudiedStrike>& strikes,
                          const std::vector<ModelStrike>& model, const HeardObject& object,
                          const synth::damping::DampingModel& damping,
                          const std::vector<double>& factors, const StudyOptions& options);

/// The model beside the recordings: as given, with each strike's lowest mode scaled to the highest
/// peak, to the lowest of the ten highest, and fitted if there is a fit. Where sound is radiated,
/// the scaled ones have frequencies alone: equivalent sources of every recording's own scale would
/// take many times as long as all the rest.
/// @param damping  of the material given
std::vector<ModelVariant> compare_variants(const std::vector<StudiedStrike>& strikes,
                                           const std::vector<ModelStrike>& model,
                                           const HeardObject& given,
                                           const synth::damping::DampingModel& damping,
                                           const HeardObject* fitted, const StudyFit* fit,
                                           const StudyOptions& options);

}  // namespace carillon::eval::recorded_objects
