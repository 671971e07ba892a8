#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/damping/fit_damping.hpp"
#include "eval/material/pitch_posterior.hpp"

namespace carillon::eval::material {

/// A tone and the mode that it is of.
struct MatchedTone {
  features::Feature feature;  ///< the strongest of the tone, of the recording that has it loudest
  double mode_frequency = 0;  ///< in the material that matches best [Hz]
  double probability = 0;     ///< that the tone is a mode's
};

/// A damping law, and what its numbers are known to.
struct FittedLaw {
  synth::damping::DampingModel model;
  std::vector<core::Range> confidence95;  ///< one for each alpha; infinite ends: not bounded
};

/// A material from pitches alone. What is not determined is not there.
struct PitchEstimate {
  std::optional<double> specific_modulus;  ///< E / density [m^2/s^2], the posterior's median
  core::Range modulus95 = {};              ///< [m^2/s^2]
  /// What the frequencies of the assumed material are multiplied by at the same Poisson's ratio:
  /// the root of the specific moduli's ratio. The body's own pitches are meant: what its elements
  /// are sharp by is in the interval and not in the scale.
  std::optional<double> frequency_scale;
  core::Range scale95 = {};
  std::optional<double> poisson_ratio;  ///< where several were tried
  core::Range poisson95 = {};
  std::optional<FittedLaw> damping;  ///< of the matched tones
  std::optional<double> room_rt60;   ///< [s]; none: no room is heard
  std::vector<MatchedTone> matches;  ///< empty where the modulus is not determined
  double log_evidence = 0;           ///< PitchPosterior::log_evidence
  double chance = 1;                 ///< chance_of_match()
  double scatter_cents = 0;          ///< of the tones about the modes, at the posterior's maximum
  double sharpness = 0;              ///< of the modes there, in units of their estimated errors
  std::size_t tones = 0;
  std::string undetermined;  ///< why there is no specific modulus; "" where there is one
  std::vector<std::string> remarks;

  bool complete() const { return specific_modulus && damping; }
};

/// The material of one object from the pitches of recordings of it, whatever their gains, wherever
/// it was struck and heard.
///
/// The modulus is stated where the tones speak for the object's modes (log evidence above 3, and
/// such a match comes by chance less than once in a hundred times), three of them at the least are
/// modes', and 95 % of the posterior lie in one place. The damping law is fitted to the matched
/// tones of every recording: in a room by fit_in_room(), else with errors in proportion to the
/// damping and room for excess.
/// @param recordings  of one object
/// @param modes       as for pitch_posterior()
/// @param rt60        of the room, by octave from 125 Hz on [s]; 0: no room; empty: not known, it
///                    is told by what surrounds the matched tones (room_sound.hpp)
/// @throws InputError  no modes
PitchEstimate estimate_from_pitches(std::span<const features::FeatureSet> recordings,
                                    std::span<const ModePitches> modes,
                                    const damping::DampingLaw& law,
                                    std::span<const double> rt60 = {},
                                    const PitchPrior& prior = {});

}  // namespace carillon::eval::material
