#include "eval/features/detail/strikes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers.hpp"

namespace carillon::eval::features {

namespace {

constexpr std::size_t order = 32;
constexpr double frame_length = 0.001;     ///< [s]
constexpr double predicted_from = 0.4;     ///< after the loudest frame [s]
constexpr std::size_t frames_before = 25;  ///< in which nothing is alike
constexpr std::size_t own_frames = 3;      ///< of a strike itself
constexpr std::size_t around_burst = 2;    ///< frames on either side in which it begins
constexpr double above_any = 6;            ///< of the frames before
constexpr double above_median = 15;
/// Of the largest: -30 dB before it, where people talk and codecs smear, and -40 dB after it.
constexpr double below_before = 1e-3, below_after = 1e-4;

std::vector<double> frame_energies(std::span<const double> samples, std::size_t frame) {
  std::vector<double> energies(samples.size() / frame);
  for (std::size_t k = 0; k < energies.size(); ++k) {
    for (const double sample : samples.subspan(k * frame, frame)) energies[k] += sample * sample;
  }
  return energies;
}

/// @return  as many values as samples
std::vector<double> filtered(std::span<const double> samples, std::span<const double> filter) {
  std::vector<double> out(samples.size(), 0);
  for (std::size_t j = 0; j < filter.size(); ++j) {
    for (std::size_t n = j; n < samples.size(); ++n) out[n] += filter[j] * samples[n - j];
  }
  return out;
}

}  // namespace

std::vector<double> prediction_error_filter(std::span<const double> samples, std::size_t length) {
  std::vector<double> filter = {1.0};
  if (samples.size() < 2 * length + 2) return filter;
  std::vector<double> forward(samples.begin() + 1, samples.end());
  std::vector<double> backward(samples.begin(), samples.end() - 1);
  double power = 0;
  for (const double sample : samples) power += sample * sample;
  for (std::size_t m = 0; m < length; ++m) {
    double product = 0, squares = 0;
    for (std::size_t n = 0; n < forward.size(); ++n) {
      product += forward[n] * backward[n];
      squares += forward[n] * forward[n] + backward[n] * backward[n];
    }
    // Of sound without noise nothing is left but rounding.
    if (!(squares > 1e-20 * power)) break;
    const double reflection = -2 * product / squares;
    const std::vector<double> before = filter;
    filter.push_back(0);
    for (std::size_t j = 1; j < filter.size(); ++j) {
      filter[j] += reflection * before[filter.size() - 1 - j];
    }
    for (std::size_t n = 0; n + 1 < forward.size(); ++n) {
      // The next order's pairs: backward errors come one sample later.
      const double next = forward[n + 1] + reflection * backward[n + 1];
      backward[n] += reflection * forward[n];
      forward[n] = next;
    }
    forward.pop_back();
    backward.pop_back();
  }
  return filter;
}

std::vector<std::size_t> find_strikes(std::span<const double> samples, double sample_rate) {
  const auto frame = std::max<std::size_t>(1, static_cast<std::size_t>(frame_length * sample_rate));
  std::vector<double> steps(samples.size(), 0);
  for (std::size_t n = 1; n < samples.size(); ++n) steps[n] = samples[n] - samples[n - 1];
  const std::vector<double> loudness = frame_energies(steps, frame);
  if (loudness.empty()) return {};
  const auto loudest = static_cast<std::size_t>(std::max_element(loudness.begin(), loudness.end()) -
                                                loudness.begin());
  const std::size_t from = loudest * frame;
  const std::size_t to =
      std::min(samples.size(), from + static_cast<std::size_t>(predicted_from * sample_rate));
  const std::vector<double> filter =
      prediction_error_filter(samples.subspan(from, to - from), order);
  const std::vector<double> errors = filtered(samples, filter);
  const std::vector<double> error = frame_energies(errors, frame);

  // The largest of the bursts that the loudest frame may belong to.
  double largest = 0;
  const std::size_t around = loudest > frames_before ? loudest - frames_before : 0;
  for (std::size_t k = around; k < std::min(error.size(), loudest + own_frames); ++k) {
    largest = std::max(largest, error[k]);
  }
  std::vector<std::size_t> strikes;
  std::vector<double> before;
  std::size_t first = 0;  // frame after what belongs to the strike before
  for (std::size_t k = 1; k < error.size(); ++k) {
    const std::size_t begin = std::max(first, k > frames_before ? k - frames_before : 0);
    if (begin >= k) continue;
    const double burst = std::max(error[k], k + 1 < error.size() ? error[k + 1] : 0);
    const double below = k < loudest ? below_before : below_after;
    if (!(burst > below * largest) || error[k] < 0.05 * burst) continue;
    before.assign(error.begin() + static_cast<std::ptrdiff_t>(begin),
                  error.begin() + static_cast<std::ptrdiff_t>(k));
    if (burst < above_any * *std::max_element(before.begin(), before.end())) continue;
    if (burst < above_median * core::median(before)) continue;
    const std::size_t shows = std::max(begin, k > around_burst ? k - around_burst : 0) * frame;
    const std::size_t over = std::min(samples.size(), (k + around_burst) * frame);
    strikes.push_back(shows + change_of_power(std::span(errors).subspan(shows, over - shows)));
    first = k + own_frames + (k + 1 < error.size() && error[k + 1] > error[k] ? 1 : 0);
  }
  return strikes;
}

std::size_t change_of_power(std::span<const double> samples) {
  constexpr std::size_t margin = 3;
  if (samples.size() < 2 * margin + 2) return 0;
  double all = 0, peak = 0;
  for (const double sample : samples) {
    all += sample * sample;
    peak = std::max(peak, std::abs(sample));
  }
  // Digital silence has no likelihood, and what a codec makes of it before a strike is none.
  const double floor = 1e-4 * peak * peak;
  const auto count = static_cast<double>(samples.size());
  double sum = 0, smallest = std::numeric_limits<double>::infinity();
  std::size_t best = 0;
  for (std::size_t k = 0; k + margin < samples.size(); ++k) {
    const auto here = static_cast<double>(k);
    if (k >= margin) {
      const double value = here * std::log(sum / here + floor) +
                           (count - here) * std::log((all - sum) / (count - here) + floor);
      if (value < smallest) {
        smallest = value;
        best = k;
      }
    }
    sum += samples[k] * samples[k];
  }
  return best;
}

}  // namespace carillon::eval::features
