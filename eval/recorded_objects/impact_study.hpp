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

namespace carillon::eval::recorded_objects {

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
  damping::DampingLaw law;  ///< of the fit
  damping::Estimator estimator = damping::Estimator::emg_relative;
};

/// One recording and what is taken from it.
struct StudiedStrike {
  RecordedStrike recorded;
  std::vector<double> samples;
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

/// What the fit comes to.
struct StudyFit {
  material::JointEstimate joint;
  synth::damping::DampingModel damping;  ///< of the material, without what is radiated
  std::size_t points = 0;                ///< matched modes that the damping was fitted to
  /// Of the damping's numbers, as those modes bound them; empty: the damping is the joint
  /// estimate's.
  std::vector<core::Range> confidence95;
  std::vector<std::string> remarks;
};

/// What the recordings hold. One that holds nothing to compare (a sample that is not finite,
/// silence) is left out, of `model` and `given` too.
/// @param rows     one for each strike of `model`
/// @param remarks  get a line for each recording that is left out
/// @throws InputError  none is left; says why
std::vector<StudiedStrike> study_strikes(const ImpactFolder& folder,
                                         const std::vector<RecordedStrike>& rows,
                                         const StudyOptions& options,
                                         std::vector<ModelStrike>& model, HeardObject& given,
                                         std::vector<std::string>& remarks);

/// Specific modulus and damping from all strikes, with the object as the fitted material radiates.
/// @param given  the object with the material it is taken to be of
/// @param fitted  becomes the object with the specific modulus found
/// @throws InputError  no recording that a material can be estimated from
StudyFit fit_material(const std::vector<StudiedStrike>& strikes,
                      const std::vector<ModelStrike>& model, const HeardObject& given,
                      HeardObject& fitted, const StudyOptions& options,
                      const std::filesystem::path& cache);

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
