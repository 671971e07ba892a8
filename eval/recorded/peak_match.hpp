#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "eval/recorded/window_spectrum.hpp"

namespace carillon::eval::recorded {

/// Modes of a model against as many of the highest peaks of a recording's spectrum (Hiner 2024,
/// section 4).
struct PeakMatch {
  std::size_t modes = 0;   ///< compared with ...
  std::size_t peaks = 0;   ///< ... so many
  double rank_rms_hz = 0;  ///< root mean square of the differences of the n-th mode and the n-th
                           ///< peak by frequency, of the fewer of both; NaN for none
  double rank_rms_cents = 0;
  std::size_t matched = 0;       ///< pairs within `widest`, one peak for a mode
  double matched_by_chance = 0;  ///< pairs_by_chance()
  std::vector<double> cents;     ///< 1200 log2(mode / peak) of each pair
};

/// How many pairs chance makes: their mean number when all of `modes` are moved together by a
/// minor third or so (200 to 600 cents up and down), where nothing fits but by chance.
/// @param modes, others  frequencies [Hz]
/// @param widest         distance within which two are a pair [cents]
double pairs_by_chance(std::span<const double> modes, std::span<const double> others,
                       double widest);

/// @param modes   frequencies [Hz], ascending
/// @param peaks   ascending frequencies
/// @param widest  distance within which a mode and a peak are a pair [cents]
/// @throws InputError  a frequency or `widest` that is not positive
PeakMatch match_peaks(std::span<const double> modes, std::span<const SpectralPeak> peaks,
                      double widest);

/// Of several strikes: numbers add up, mean squares are those of all.
PeakMatch joined(std::span<const PeakMatch> matches);

/// Which peak the lowest mode is scaled to.
enum class ScalePeak {
  highest,       ///< of all: "the peak frequency in the true spectrum" (Hiner 2024, section 4.1)
  lowest_of_ten  ///< the lowest of the ten highest, as the program behind that paper has it
};

/// @param peaks  ascending; not empty
double scale_frequency(std::span<const SpectralPeak> peaks, ScalePeak choice);

}  // namespace carillon::eval::recorded
