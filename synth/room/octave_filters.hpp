#pragma once

#include <complex>
#include <span>
#include <vector>

#include "synth/room/room_acoustics.hpp"

namespace carillon::synth::room {

/// How far an edge is crossed at a frequency: 0 below it, 1 above it, between them a raised cosine
/// in log2 f.
/// @param half_width  of the crossing [octaves]
double crossing(double frequency, double edge, double half_width);

/// Shares of the octaves at a frequency: a partition of unity, raised cosines in log2 f across the
/// edges between neighbours. Below the lowest edge all belongs to the lowest octave, above the
/// highest to the highest of `octaves`.
/// @param half_width  of the crossing [octaves], at most 1/2
OctaveValues octave_fractions(double frequency, std::size_t octaves, double half_width);

/// Minimum-phase filters with a gain in each octave: what a wave has lost at walls and in air.
///
/// log H = sum over octaves of x_b C_b, where C_b is the minimum-phase log spectrum of octave b's
/// share. The x_b are set so that the mean of |H|^2 over each octave is the gain's square.
class ReflectionFilters {
 public:
  /// @throws InputError  a sample rate that is not positive
  explicit ReflectionFilters(double sample_rate);

  std::size_t fft_size() const { return size_; }
  std::size_t octaves() const { return octaves_; }

  /// Multiplies a spectrum (fft_size() / 2 + 1 bins) by the filter of `gains` (0 or more, relative
  /// amplitudes). Octaves more than 60 dB below the loudest are made 60 dB below it; with no gain
  /// at all the spectrum becomes 0.
  void apply(const OctaveValues& gains, std::span<std::complex<double>> spectrum) const;

 private:
  struct Point {
    std::size_t octave;  ///< whose mean it belongs to
    OctaveValues fractions;
  };
  OctaveValues exponents(const OctaveValues& gains) const;

  std::size_t size_;
  std::size_t octaves_;
  std::vector<Point> points_;  ///< evenly over each octave
  std::array<std::vector<std::complex<double>>, octave_count> log_spectra_;
};

}  // namespace carillon::synth::room
