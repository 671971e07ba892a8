#pragma once

#include <span>
#include <vector>

#include "core/numbers.hpp"
#include "eval/material/heard_tones.hpp"
#include "eval/material/mode_pitches.hpp"

namespace carillon::eval::material {

struct PitchPrior {
  double min_modulus = 1e5;  ///< of E / density [m^2/s^2], even in its logarithm
  double max_modulus = 1e9;
  double min_frequency = 50;  ///< band in which tones are heard [Hz]
  double max_frequency = 20000;
};

/// What is assumed of an object beside its specific modulus: the nuisances of a likelihood.
struct PitchNuisance {
  double poisson_ratio = 0;
  /// Share of their estimated errors by which the modes are sharp.
  double sharpness = 0;
  double scatter = 0;  ///< of an object's pitches about those of its modes [cents]
};

/// Which tones are modes', and how surely.
struct ToneMatch {
  std::size_t tone = 0;
  std::size_t mode = 0;
  double mode_frequency = 0;  ///< as solved, less what it is sharp by [Hz]
  double probability = 0;     ///< that the tone is a mode's and not spurious
};

/// What tones say of a specific modulus.
struct PitchPosterior {
  /// Candidates and their posterior probabilities, which sum to 1; ascending, where it is not
  /// negligible.
  std::vector<double> log_moduli, probabilities;
  /// Logarithm of how much likelier the tones are with this object's modes than without, over all
  /// that was assumed beforehand.
  double log_evidence = 0;
  double modulus = 0;             ///< median [m^2/s^2]
  core::Range confidence95 = {};  ///< [m^2/s^2]
  std::vector<double> poisson_ratios, poisson_probabilities;
  PitchNuisance best;       ///< at the posterior's maximum
  double best_modulus = 0;  ///< there [m^2/s^2]
};

/// Log-likelihood of tones, over that of tones without any mode.
///
/// A tone is a mode's with its certainty c, else spurious and even in log frequency. A mode's tone
/// lies about its mode by Student's t of 4 degrees of freedom, with the scatter, the tone's own
/// error and 3 % of the mode's for its scale; which mode it is goes with their weights. The sum
/// over all assignments is therefore a product over tones of
///     1 - c + c B sum_j w_j t(x - x_j) / sum_j w_j,
/// where j runs over the modes of the band and B is its width in log frequency. A set of many modes
/// that comes near to every tone gains nothing; modes that are not heard cost their share of the
/// sum. Tones above what is known of the modes say nothing.
double log_likelihood(std::span<const HeardTone> tones, const ModePitches& modes,
                      double specific_modulus, const PitchNuisance& nuisance,
                      const PitchPrior& prior = {});

/// The same with the sharpness and the scatter of pitch_posterior()'s that make it largest.
double best_log_likelihood(std::span<const HeardTone> tones, const ModePitches& modes,
                           double specific_modulus, const PitchPrior& prior = {});

/// Posterior of the specific modulus, with Poisson's ratio (even between the first and the last of
/// the sets), sharpness (even from 0 to 5/4, as estimates may be a fifth too low) and scatter (even
/// in its logarithm from 1/4 to 64 cents) marginalised.
/// @param modes  of one object and specific modulus, by ascending Poisson's ratio; those between
///               them are interpolated
/// @throws InputError  no modes
PitchPosterior pitch_posterior(std::span<const HeardTone> tones, std::span<const ModePitches> modes,
                               const PitchPrior& prior = {});

/// Modes of the tones at the posterior's maximum; every mode has at most one, every tone too.
std::vector<ToneMatch> match_tones(std::span<const HeardTone> tones,
                                   std::span<const ModePitches> modes,
                                   const PitchPosterior& posterior, const PitchPrior& prior = {});

/// How likely the best score would be if the tones had nothing to do with the modes: against those
/// of tones that were each moved at random by one and a half semitones, which leaves the density of
/// tones and modes as it is and looks as far for a match (Gumbel's law of extremes, fitted by its
/// moments).
/// @param best  of the posterior: at its sharpness and scatter the tones are compared
double chance_of_match(std::span<const HeardTone> tones, std::span<const ModePitches> modes,
                       const PitchNuisance& best, const PitchPrior& prior = {});

/// The modes at a Poisson's ratio between those that are known.
ModePitches pitches_at(std::span<const ModePitches> modes, double poisson_ratio);

}  // namespace carillon::eval::material
