#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/random.hpp"

namespace carillon::synth::recording {

/// Noise made from random numbers.
enum class NoiseKind {
  white,  ///< independent normal samples
  pink,   ///< -3 dB per octave from 20 Hz up, nearly flat below 2 Hz
  brown,  ///< -6 dB per octave from 20 Hz up, flat below 5 Hz
  hum,    ///< mains: 50 or 60 Hz and 19 harmonics with random phases and levels
  babble  ///< voices without words: speech-shaped noise, syllables of several talkers
};

/// Names of the kinds in configurations, in the order of the enumeration.
const std::vector<std::string>& noise_kind_names();
/// Their spectra in words, in the same order.
const std::vector<std::string>& noise_kind_spectra();
/// @throws InputError  names the nearest kind
NoiseKind noise_kind(const std::string& name);

/// Stationary noise of no particular level, which the signal-to-noise ratio sets. It begins in the
/// middle of itself: nothing swells up, and nothing is repeated.
///
/// white, pink, brown and babble are normally distributed (babble given its syllables); formulas
/// and sources in docs/sound/noise.md.
///
/// @param count        samples
/// @param sample_rate  [Hz], 1 kHz to 10 MHz
/// @throws InputError  the rate is out of range
std::vector<double> generate_noise(NoiseKind kind, std::size_t count, double sample_rate,
                                   core::RandomStream& random);

/// Noise for `rows` listeners of one place, one after the other: independent in each, but for hum,
/// whose mains (50 or 60 Hz, and how far astray) is one for all; levels and phases differ.
/// @return  rows x count samples
std::vector<double> generate_rows(NoiseKind kind, std::size_t count, std::size_t rows,
                                  double sample_rate, core::RandomStream& random);

/// Talkers of `NoiseKind::babble`.
constexpr int babble_talkers = 6;

/// Loudness of babble over time before it is given its spectrum: root of the talkers' summed power,
/// each of them a row of syllables (raised cosines of 0.12 to 0.35 s with levels 4 dB apart, one in
/// five is a pause). A sum of independent normal noises with envelopes e_i is a normal noise with
/// the envelope sqrt(sum e_i^2), so one noise does for all talkers.
///
/// @return `count` values, mean square 1 in expectation
std::vector<double> babble_envelope(int talkers, std::size_t count, double sample_rate,
                                    core::RandomStream& random);

}  // namespace carillon::synth::recording
