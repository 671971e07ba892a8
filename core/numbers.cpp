#include "core/numbers.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace carillon::core {

namespace {

template <class T>
double peak_of(std::span<const T> samples) {
  double peak = 0;
  for (const T sample : samples) peak = std::max(peak, std::abs(static_cast<double>(sample)));
  return peak;
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return nan;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*std::max_element(values.begin(), middle) + *middle);
}

double quantile(std::span<const double> values, double fraction) {
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  return quantile_of_sorted(sorted, fraction);
}

double quantile_of_sorted(std::span<const double> ascending, double fraction) {
  if (ascending.empty()) return nan;
  const double place = fraction * static_cast<double>(ascending.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(place));
  const std::size_t above = std::min(below + 1, ascending.size() - 1);
  return std::lerp(ascending[below], ascending[above], place - static_cast<double>(below));
}

double peak(std::span<const float> samples) {
  return peak_of(samples);
}

double peak(std::span<const double> samples) {
  return peak_of(samples);
}

double cents(double ratio) {
  return 1200 * std::log2(ratio);
}

double decibels(double power_ratio) {
  return 10 * std::log10(power_ratio);
}

double amplitude_decibels(double ratio) {
  return 20 * std::log10(ratio);
}

}  // namespace carillon::core
