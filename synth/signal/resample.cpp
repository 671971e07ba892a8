#include "synth/signal/resample.hpp"

#include <fmt/format.h>
#include <soxr.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::synth::signal {

namespace {

constexpr double largest_ratio = 1000;

}  // namespace

std::vector<double> resample(std::span<const double> samples, double from, double to) {
  const bool rates = from > 0 && to > 0 && std::isfinite(from) && std::isfinite(to);
  if (!rates || from > largest_ratio * to || to > largest_ratio * from) {
    throw core::InputError(fmt::format("resampling from {} Hz to {} Hz", from, to),
                           fmt::format("both rates must be positive and at most a factor of {} "
                                       "apart",
                                       largest_ratio));
  }
  const auto bad = std::find_if(samples.begin(), samples.end(),
                                [](double value) { return !std::isfinite(value); });
  if (bad != samples.end()) {
    throw core::InputError(
        fmt::format("resampling: sample {} is not a finite number", bad - samples.begin()));
  }
  if (from == to) return {samples.begin(), samples.end()};
  const double exact = static_cast<double>(samples.size()) * (to / from);
  std::vector<double> result(static_cast<std::size_t>(std::lround(exact)));
  if (result.empty()) return result;
  const soxr_io_spec_t io = soxr_io_spec(SOXR_FLOAT64_I, SOXR_FLOAT64_I);
  const soxr_quality_spec_t quality = soxr_quality_spec(SOXR_VHQ, 0);
  // One thread: the ranks share the cores already.
  const soxr_runtime_spec_t runtime = soxr_runtime_spec(1);
  std::size_t made = 0;
  // All of the input is taken where nobody asks how much was: else as much as the output's rounded
  // length needs, and if that is a sample less, the end is never made.
  const soxr_error_t error =
      soxr_oneshot(from, to, 1, samples.data(), samples.size(), nullptr, result.data(),
                   result.size(), &made, &io, &quality, &runtime);
  if (error != nullptr) {
    throw core::InputError(fmt::format("resampling from {} Hz to {} Hz: {}", from, to, error));
  }
  // The last sample of a fraction can be missing; it lies beyond the end, where there is silence.
  std::fill(result.begin() + static_cast<std::ptrdiff_t>(made), result.end(), 0.0);
  return result;
}

}  // namespace carillon::synth::signal
