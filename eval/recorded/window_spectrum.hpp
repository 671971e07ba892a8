#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace carillon::eval::recorded {

/// Amplitudes of a stretch of a sound: a lasting sinusoid of amplitude a shows a peak of a.
struct WindowSpectrum {
  double bin_width = 0;            ///< [Hz]
  std::vector<double> amplitudes;  ///< at 0, bin_width, ... up to half the sample rate
};

/// Which stretch of a recording is transformed: samples first <= n < end.
struct Stretch {
  std::size_t first = 30;  ///< Hiner 2024, section 4.2, at 48 kHz
  std::size_t end = 3000;
};

/// Fourier transform of as many points as the stretch has samples, after the Blackman-Harris window
/// of four terms and -92 dB (Harris 1978) in its periodic form. What the recording does not have of
/// the stretch counts as silence.
/// @throws InputError  an empty stretch, a rate that is not positive, a sample that is not finite
WindowSpectrum window_spectrum(std::span<const double> samples, double sample_rate,
                               const Stretch& stretch = {});

/// A local maximum of a spectrum.
struct SpectralPeak {
  double frequency = 0;  ///< [Hz], of the parabola through the logarithms of three bins
  double amplitude = 0;  ///< its top
};

/// The highest local maxima above a frequency, in ascending order of their frequencies.
/// @param count  at most
std::vector<SpectralPeak> highest_peaks(const WindowSpectrum& spectrum, std::size_t count,
                                        double min_frequency);

}  // namespace carillon::eval::recorded
