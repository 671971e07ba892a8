#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/features/feature.hpp"

namespace carillon::eval::features {

enum class FeatureMethod {
  esprit,  ///< ESPRIT in decimated bands
  peaks    ///< the papers': peaks of spectrograms of several resolutions, fitted one by one
};

struct FeatureOptions {
  FeatureMethod method = FeatureMethod::esprit;
  std::optional<double> onset;   ///< [s] where the strike begins; none: it is found
  double contact_time = 0.003;   ///< after the onset, left out: the modes are still driven [s]
  double min_frequency = 20;     ///< [Hz]
  double max_frequency = 20000;  ///< [Hz]; never above 0.95 of half the sample rate
  /// What decays slower is a hum and all else is a mode [1/s]; none: told by what was there before
  /// the strike, by mains frequencies, and by whether it decays.
  std::optional<double> min_decay_rate;
  double duration = 20;  ///< that is analysed after the contact, at most [s]
  /// Reverberation times of the room by octave from 125 Hz on [s], the last one holds above; empty:
  /// not known, 0: does not reverberate. Modes with d above 6.9 / rt60 and what may be the room's
  /// own decay are marked.
  std::vector<double> rt60;
  /// Whether what cannot be told from the room's decay is looked for, too, and marked.
  bool keep_reverberant = true;
  double min_level = -40;          ///< energy of a mode against the strongest's [dB]
  std::size_t max_features = 100;  ///< of a channel, those of most energy
  /// Fraction of the power of the spectrograms that the papers' peaks are to account for: then no
  /// more are looked for.
  double explained = 0.9999;
};

/// A steady tone that is not the object's, or does not decay as long as it is heard.
struct Hum {
  double frequency = 0;   ///< [Hz]
  double decay_rate = 0;  ///< [1/s], may be negative
  double amplitude = 0;
};

/// What a recording holds.
struct FeatureSet {
  std::vector<Feature> features;  ///< by frequency, ascending
  std::vector<Hum> hums;
  double sample_rate = 0;  ///< [Hz]
  double onset = 0;        ///< [s] from the beginning of the recording
  double begin = 0;        ///< what was analysed [s]: after contact and after what was clipped,
  double end = 0;          ///< and before the next strike or the end
  double explained = 0;    ///< fraction of the energy from begin to end, without the hums, that the
                           ///< features make up
  std::size_t clipped = 0;           ///< samples at full scale
  std::vector<double> residual;      ///< from begin to end: what neither features nor hums are
  std::vector<std::string> remarks;  ///< what was left out and why, for people
  /// Why there are no features ("silent", "no decaying tone above the noise"); "" where there are.
  std::string nothing;
};

/// Up to which modes are looked for [Hz]: max_frequency, or 0.95 of half the sample rate.
double highest_mode(double sample_rate, const FeatureOptions& options);

/// What any extraction asks of its input.
/// @throws InputError  as extract_features()
void check_extraction(std::span<const double> samples, double sample_rate,
                      const FeatureOptions& options);

struct Segment;

/// A set without features: onset, begin, end, remarks and what there is not, as the segment has
/// them.
FeatureSet set_of_segment(const Segment& segment, double sample_rate);

/// Modes of a struck object from a recording of one channel, at any rate and of any length.
/// @param samples  full scale 1
/// @throws InputError  a sample that is not finite (names its place), a rate that is not positive,
///                     options out of range
FeatureSet extract_features(std::span<const double> samples, double sample_rate,
                            const FeatureOptions& options = {});

}  // namespace carillon::eval::features
