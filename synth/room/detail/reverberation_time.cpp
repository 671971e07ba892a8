#include "synth/room/detail/reverberation_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "synth/room/octave_filters.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::synth::room {

using core::InputError;

namespace {

/// Least squares through (x0 + i, y[i]).
struct Line {
  double slope = 0;
  double at_zero = 0;
  double correlation = 0;
};

Line fit(std::span<const double> y, std::size_t x0) {
  const auto n = static_cast<double>(y.size());
  const double mean_x = static_cast<double>(x0) + (n - 1) / 2;
  double mean_y = 0;
  for (const double v : y) mean_y += v / n;
  double xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double dx = static_cast<double>(x0 + i) - mean_x;
    const double dy = y[i] - mean_y;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
  }
  Line line;
  line.slope = xy / xx;
  line.at_zero = mean_y - line.slope * mean_x;
  line.correlation = yy > 0 ? xy / std::sqrt(xx * yy) : 0;
  return line;
}

/// Squares scaled to a largest value of 1 (levels are relative, and squares of extremes are not
/// numbers); silence at the end is left out.
std::vector<double> powers(std::span<const double> response) {
  if (!std::ranges::all_of(response, [](double v) { return std::isfinite(v); })) {
    throw InputError("reverberation time of a response with a value that is not finite");
  }
  const double largest = core::peak(response);
  if (largest == 0) {
    throw InputError("reverberation time of a response that is silent",
                     "give a response with at least one value other than 0");
  }
  while (response.back() == 0) response = response.first(response.size() - 1);
  std::vector<double> power(response.size());
  std::transform(response.begin(), response.end(), power.begin(),
                 [largest](double v) { return v / largest * (v / largest); });
  return power;
}

double sum(std::span<const double> values) {
  double total = 0;
  for (const double v : values) total += v;
  return total;
}

/// Mean levels of blocks [dB]. A zero crossing is no end of a decay: -300 dB stands for silence.
std::vector<double> block_levels(std::span<const double> power, std::size_t block) {
  std::vector<double> levels;
  for (std::size_t first = 0; first + block <= power.size(); first += block) {
    levels.push_back(
        core::decibels(sum(power.subspan(first, block)) / static_cast<double>(block) + 1e-30));
  }
  return levels;
}

/// Where the decay is 5 dB above the power of its last tenth, the noise floor if there is one: a
/// line through the levels of blocks, from the loudest down to 10 dB above that floor. Nothing when
/// it does not get there.
std::optional<std::size_t> end_of_decay(std::span<const double> power) {
  const std::size_t tenth = std::max<std::size_t>(1, power.size() / 10);
  const double floor = core::decibels(sum(power.last(tenth)) / static_cast<double>(tenth) + 1e-30);
  // Long blocks first: they do not take the noise's own dips for its end.
  for (const std::size_t blocks : {50U, 200U, 1000U}) {
    const std::size_t block = std::max<std::size_t>(1, power.size() / blocks);
    const std::vector<double> levels = block_levels(power, block);
    const auto top = std::max_element(levels.begin(), levels.end());
    const auto bottom = std::find_if(top, levels.end(), [&](double l) { return l < floor + 10; });
    if (bottom - top < 4) continue;
    const auto first = static_cast<std::size_t>(top - levels.begin());
    const Line line =
        fit(std::span(levels).subspan(first, static_cast<std::size_t>(bottom - top)), first);
    if (!(line.slope < 0)) continue;
    const double crossing = (floor + 5 - line.at_zero) / line.slope + 0.5;
    return static_cast<std::size_t>(
        std::clamp(crossing * static_cast<double>(block), 1.0, static_cast<double>(power.size())));
  }
  return {};
}

}  // namespace

std::optional<DecayFit> reverberation_time(std::span<const double> response, double sample_rate,
                                           double decay) {
  if (!(sample_rate > 0) || !std::isfinite(sample_rate) || !(decay > 0) || !std::isfinite(decay)) {
    throw InputError(fmt::format("reverberation time over {} dB at {} Hz: both must be positive",
                                 decay, sample_rate));
  }
  std::vector<double> power = powers(response);
  const auto end = end_of_decay(power);
  if (!end || *end < 8) return {};
  power.resize(*end);
  std::vector<double> rest(power.size());
  double total = 0;
  for (std::size_t n = power.size(); n-- > 0;) rest[n] = total += power[n];
  // What an exponential decay has beyond the end follows from its last eighth and its slope; the
  // slope from the curve with that added. A few rounds settle both.
  const std::size_t stretch = power.size() / 8;
  const double last = sum(std::span<const double>(power).last(stretch));
  double beyond = 0;
  std::optional<DecayFit> found;
  std::vector<double> curve;
  for (int round = 0; round < 50; ++round) {
    curve.clear();
    std::size_t first = 0;
    for (std::size_t n = 0; n < rest.size(); ++n) {
      const double l = core::decibels((rest[n] + beyond) / (rest[0] + beyond));
      if (l < -5 - decay) break;
      if (l > -5) {
        first = n + 1;
      } else {
        curve.push_back(l);
      }
    }
    if (curve.size() < 3) return {};
    const Line line = fit(curve, first);
    if (!(line.slope < 0)) return {};
    const double before = found ? found->rt60 : 0;
    found = DecayFit{-60 / (line.slope * sample_rate), line.correlation,
                     -core::decibels((rest.back() + beyond) / (rest[0] + beyond))};
    beyond =
        last / std::expm1(-line.slope * std::numbers::ln10 / 10 * static_cast<double>(stretch));
    if (std::abs(found->rt60 - before) <= 1e-13 * found->rt60) break;
  }
  if (found->dynamic_range < decay + 10) return {};
  return found;
}

std::vector<double> octave_band(std::span<const double> signal, double sample_rate, double centre) {
  if (!(sample_rate > 0) || !(centre > 0) || centre / std::numbers::sqrt2 >= sample_rate / 2) {
    throw InputError(
        fmt::format("no octave of {} Hz at a sample rate of {} Hz", centre, sample_rate),
        "its lower edge must lie below half the sample rate");
  }
  if (signal.empty()) return {};
  // Silence before and after, so that the ringing of one end does not come round to the other.
  const auto ringing = static_cast<std::size_t>(std::ceil(16 * sample_rate / centre));
  signal::RealFft fft(signal::good_fft_size(signal.size() + ringing));
  std::fill(std::copy(signal.begin(), signal.end(), fft.signal().begin()), fft.signal().end(), 0.0);
  fft.forward();
  constexpr double half_width = 1.0 / 16;  // the edges are crossed within the outer eighths
  const double low = centre / std::numbers::sqrt2, high = centre * std::numbers::sqrt2;
  const double inward = std::exp2(half_width);
  for (std::size_t k = 0; k < fft.bins(); ++k) {
    const double f = static_cast<double>(k) * sample_rate / static_cast<double>(fft.size());
    fft.spectrum()[k] *= f <= low || f >= high ? 0.0
                                               : crossing(f, low * inward, half_width) *
                                                     (1 - crossing(f, high / inward, half_width));
  }
  fft.inverse();
  return {fft.signal().begin(), fft.signal().begin() + static_cast<std::ptrdiff_t>(signal.size())};
}

}  // namespace carillon::synth::room
