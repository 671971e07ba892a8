#pragma once

#include <span>

namespace carillon::eval::perception {

/// How far two sounds' short-time spectra are apart, mean over three resolutions.
struct SpectralDistance {
  double convergence = 0;    ///< || |X| - |Y| ||_F over || |X| ||_F, X the reference's
  double log_magnitude = 0;  ///< mean of | ln|X| - ln|Y| |
  double total() const { return convergence + log_magnitude; }
};

/// Multi-resolution distance of short-time Fourier transforms (Yamamoto, Song and Kim 2020, eq.
/// 3 to 6): transforms of 1024, 2048 and 512 samples, hops of 120, 240 and 50, periodic Hann
/// windows of 600, 1200 and 240, frames centred on multiples of the hop, the signal mirrored at its
/// ends, powers not below 1e-7. The numbers of samples are theirs at 24 kHz, whatever the rate.
///
/// 0 for equal sounds. The second part is symmetric, the first is not: it is a fraction of the
/// reference. The floor is absolute, so quiet sounds are closer than loud ones; it makes silence
/// against silence 0, and silence against a sound finite.
/// @throws InputError  no samples, or not as many in both
SpectralDistance spectral_distance(std::span<const double> reference,
                                   std::span<const double> other);

}  // namespace carillon::eval::perception
