#pragma once

#include <complex>
#include <span>
#include <vector>

namespace carillon::eval::features {

/// One band of a signal, shifted to frequency 0 and decimated. A damped sinusoid of the signal is
/// one of the band, with the rate times `step` and another amplitude: no transients are added, as
/// every value comes from samples within the signal alone.
struct Band {
  std::vector<std::complex<double>> values;
  double centre = 0;     ///< [rad / sample]
  std::size_t step = 1;  ///< samples between two values
};

/// @param samples  real signal
/// @param centre   of the band [rad / sample]
/// @param step     decimation; the filter (a Blackman-Harris window of 8 steps) passes
///                 2 pi / step around the centre with at most 92 dB of what lies outside
/// @param maximum  values at most
Band take_band(std::span<const double> samples, double centre, std::size_t step,
               std::size_t maximum);

/// Rates per sample of the signal of the damped sinusoids in a band, by least-squares ESPRIT (Roy
/// and Kailath 1989; for impact sounds Sirdey et al. 2011): the signal space of the Hankel matrix
/// is cut at `noise` and `max_orders`, over-estimated by two, and only the rates are kept that an
/// order of three more finds again, that decay or nearly so, and that lie in the middle 80 % of the
/// band. Strongest first.
/// @param noise  standard deviation of the noise of one value
std::vector<std::complex<double>> esprit_rates(const Band& band, double noise,
                                               std::size_t max_orders);

}  // namespace carillon::eval::features
