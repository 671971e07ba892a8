#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "eval/features/detail/tone.hpp"

namespace carillon::eval::features {

/// A signal as a sum of damped sinusoids and noise, in its discrete Fourier transform, where every
/// sinusoid is far from zero in a few bins only. Fits are maximum likelihood for Gaussian noise
/// whose power varies slowly with frequency.
struct ToneFit {
  std::shared_ptr<const ToneGrid> grid;
  BinRange band;                               ///< that is looked at
  std::vector<std::complex<double>> spectrum;  ///< of the signal
  std::vector<std::complex<double>> residual;  ///< less the tones
  std::vector<double> noise;                   ///< E|noise|^2 of each bin
  double fastest = 0.5;                        ///< decay rate that is allowed [1 / sample]
  std::vector<Tone> tones;
};

/// What sinusoids of given rates would explain together.
struct ToneGain {
  std::vector<std::complex<double>> amplitudes;  ///< one for each rate, by least squares
  double gain = 0;  ///< by how much chi squared would fall: twice the gain of log-likelihood; 2 for
                    ///< each on average where there is noise alone
};
/// @param instead  indices of tones that these would replace
/// Rates that cannot be told apart gain nothing.
ToneGain gain_of(const ToneFit& fit, std::span<const std::complex<double>> rates,
                 std::span<const std::size_t> instead = {});

/// Bins in which a tone of this rate shows.
BinRange reach_of(const ToneFit& fit, std::complex<double> rate);

/// Tones whose spectra overlap with one of this rate, the nearest `maximum` of them.
/// @param alike  largest ratio of the widths of their lines
std::vector<std::size_t> neighbours(const ToneFit& fit, std::complex<double> rate,
                                    std::size_t maximum, double alike = 30);

/// Other tones in place of some, refined together (Levenberg-Marquardt) while all others are held.
struct Proposal {
  std::vector<std::size_t> replaced;  ///< indices
  std::vector<Tone> tones;
  double gain = 0;    ///< by how much chi squared falls against the replaced ones
  double shift = 0;   ///< largest change of a rate from its start, in its standard errors
  double misfit = 1;  ///< residual over noise in the range, at least 1
  std::vector<double> separation;              ///< of each tone, as ToneErrors::separation
  BinRange range;                              ///< in which the residual changes
  std::vector<std::complex<double>> residual;  ///< there
};
/// Of a line that spans many bins: a part of them, or all.
enum class Fineness { few_bins, all_bins };
/// @param start  not empty
Proposal propose(const ToneFit& fit, std::span<const std::size_t> replaced,
                 std::span<const Tone> start, int max_steps, Fineness fineness);
/// Tones that replace others take their places, further ones come last. What changes far from the
/// tones by less than the noise waits for renew().
void commit(ToneFit& fit, const Proposal& proposal);
void remove_tone(ToneFit& fit, std::size_t tone);
/// The residual from the spectrum and all tones.
void renew(ToneFit& fit);

/// Refines all tones in turn, each with its neighbours, until nothing moves by more than 2 % of its
/// standard error.
/// @param from  tones before this one have been refined, and move only where others do
void refine_all(ToneFit& fit, int max_rounds, Fineness fineness, std::size_t from = 0);

/// Standard errors of a tone by the Fisher information of it and its neighbours (Cramer-Rao).
struct ToneErrors {
  double rate_real = 0;  ///< [1 / sample]
  double rate_imag = 0;
  double amplitude_real = 0;  ///< along the phase of the amplitude
  double amplitude_imag = 0;
  double covariance = 0;  ///< of rate_real and amplitude_real
  /// How far the rate is from the nearest neighbour's in standard errors of their difference, of
  /// decay or of frequency, whichever is clearer; infinite without one. 0: they are one.
  double separation = 0;
  double misfit = 1;  ///< residual over noise within its reach, at least 1
};
ToneErrors errors_of(const ToneFit& fit, std::size_t tone);

}  // namespace carillon::eval::features
