#pragma once

#include <limits>
#include <span>
#include <vector>

namespace carillon::core {

/// A number that is not determined.
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// Closed interval: what a parameter is drawn from (a single value has low == high), or what holds
/// a number that is estimated.
struct Range {
  double low = 0;
  double high = 0;
  bool operator==(const Range&) const = default;
};

/// Median of values in any order, of an even number the mean of the two in the middle; NaN of none.
double median(std::vector<double> values);

/// Quantile of a sample, linear between its order statistics (Hyndman and Fan's type 7); NaN of
/// none.
/// @param values  in any order, finite
/// @param fraction   0 to 1
double quantile(std::span<const double> values, double fraction);
/// The same of values in ascending order.
double quantile_of_sorted(std::span<const double> ascending, double fraction);

/// Largest magnitude of samples; 0 of none.
double peak(std::span<const float> samples);
double peak(std::span<const double> samples);

/// Interval of two pitches [cents], from the ratio of their frequencies. Half of it is that of a
/// ratio of eigenvalues.
double cents(double ratio);

/// Level [dB] of a ratio of powers, and of amplitudes.
double decibels(double power_ratio);
double amplitude_decibels(double ratio);

}  // namespace carillon::core
