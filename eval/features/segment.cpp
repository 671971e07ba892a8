#include "eval/features/segment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers.hpp"
#include "eval/features/detail/damage.hpp"
#include "eval/features/detail/strikes.hpp"

namespace carillon::eval::features {

namespace {

constexpr double frame_length = 0.001;   ///< [s]
constexpr double silent = 1e-7;          ///< of full scale, -140 dB
constexpr double onset_fraction = 0.01;  ///< of the loudest energy
constexpr double same_strike = 0.004;    ///< [s]
constexpr double group_time = 0.1;       ///< in which strikes may be one group [s]
constexpr double given_window = 0.02;    ///< after an onset that is given [s]

/// Mean over three frames of the energy of the differences of neighbouring samples: what is struck
/// shows in high frequencies, which the ringing has lost.
std::vector<double> levels(std::span<const double> samples, std::size_t frame) {
  std::vector<double> energies(samples.size() / frame);
  for (std::size_t k = 0; k < energies.size(); ++k) {
    for (std::size_t n = std::max<std::size_t>(1, k * frame); n < (k + 1) * frame; ++n) {
      const double step = samples[n] - samples[n - 1];
      energies[k] += step * step;
    }
  }
  std::vector<double> out(energies.size());
  for (std::size_t k = 0; k < energies.size(); ++k) {
    const std::size_t first = k > 0 ? k - 1 : 0, last = std::min(energies.size() - 1, k + 1);
    for (std::size_t i = first; i <= last; ++i) out[k] += energies[i];
    out[k] /= static_cast<double>(last - first + 1);
  }
  return out;
}

/// Of a sound that begins slowly, or where the recording does: the sample from which on it is
/// larger than what was there before, or a hundredth of the largest.
std::size_t slow_onset(std::span<const double> samples, const std::vector<double>& level,
                       std::size_t loudest, std::size_t frame) {
  // What was there before, if the strike is not at the very beginning.
  double before = 0;
  if (loudest > 10) {
    before =
        core::median({level.begin(), level.begin() + static_cast<std::ptrdiff_t>(loudest / 2 + 1)});
    // A sound that already rings has no quiet before it.
    if (before > 0.1 * level[loudest]) before = 0;
  }
  const double threshold = std::max(onset_fraction * level[loudest], 6 * before);
  std::size_t first = loudest;
  while (first > 0 && level[first - 1] > threshold) --first;
  const std::size_t from = first > 1 ? (first - 2) * frame : 0;
  const std::size_t to = std::min(samples.size(), (loudest + 2) * frame);
  const double peak = core::peak(samples.subspan(from, to - from));
  const std::size_t quiet = from > 20 * frame ? from - 20 * frame : 0;
  const double noise = core::peak(samples.subspan(quiet, from - quiet));
  const double minimum = std::max(0.01 * peak, std::min(1.5 * noise, 0.5 * peak));
  for (std::size_t n = from; n < to; ++n) {
    if (std::abs(samples[n]) > minimum) return n;
  }
  return from;
}

/// Where the power of a sound in steady noise rises to twice what it was, before its loudest 20 ms;
/// none where it does not, or where what comes before is not steady within a factor of 2.
std::optional<std::size_t> onset_in_noise(std::span<const double> samples, double sample_rate) {
  constexpr double before_loudest = 0.3, loud = 0.02, min_rise = 2, steady = 2;
  const auto length = static_cast<std::size_t>(loud * sample_rate);
  if (samples.size() < 2 * length || length == 0) return std::nullopt;
  double energy = 0, largest = 0;
  std::size_t loudest = 0;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    energy += samples[n] * samples[n];
    if (n < length) continue;
    energy -= samples[n - length] * samples[n - length];
    if (energy <= largest) continue;
    largest = energy;
    loudest = n;
  }
  const auto window = static_cast<std::size_t>(before_loudest * sample_rate);
  const std::size_t from = loudest > window ? loudest - window : 0;
  const std::span<const double> part = samples.subspan(from, loudest + 1 - from);
  const std::size_t change = change_of_power(part);
  const auto power = [](std::span<const double> of) {
    double sum = 0;
    for (const double sample : of) sum += sample * sample;
    return of.empty() ? 0 : sum / static_cast<double>(of.size());
  };
  const std::size_t quarter = change / 4;
  if (quarter == 0) return std::nullopt;
  double before = 0, quietest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 4; ++k) {
    const double here = power(part.subspan(k * quarter, quarter));
    before = std::max(before, here);
    quietest = std::min(quietest, here);
  }
  if (before > steady * quietest) return std::nullopt;
  if (power(part.subspan(change)) < min_rise * before) return std::nullopt;
  return from + change;
}

/// Where a recording is struck, and which of that is analysed.
struct Onsets {
  std::vector<std::size_t> samples;  ///< of all strikes, in order
  std::size_t loudest = 0;           ///< index
  std::size_t taken = 0;             ///< index; the loudest, or one that follows it closely
};

Onsets find_onsets(std::span<const double> samples, double sample_rate, std::size_t frame) {
  const std::vector<double> level = levels(samples, frame);
  const auto loudest =
      static_cast<std::size_t>(std::max_element(level.begin(), level.end()) - level.begin());
  const auto seconds = [&](double time) { return static_cast<std::size_t>(time * sample_rate); };
  Onsets onsets;
  onsets.samples = find_strikes(samples, sample_rate);
  // The last one before it is loudest; none where the recording begins ringing or swells.
  const auto later = std::upper_bound(onsets.samples.begin(), onsets.samples.end(),
                                      std::min(samples.size(), (loudest + 2) * frame));
  if (later == onsets.samples.begin()) {
    // In noise that hides the begin of a sound, its differences show less than its power.
    const bool noisy =
        loudest > 10 && core::median({level.begin(), level.begin() + static_cast<std::ptrdiff_t>(
                                                                         loudest / 2 + 1)}) >
                            0.1 * onset_fraction * level[loudest];
    const auto in_noise = noisy ? onset_in_noise(samples, sample_rate) : std::nullopt;
    onsets.samples.insert(later, in_noise ? *in_noise : slow_onset(samples, level, loudest, frame));
  } else {
    onsets.loudest = static_cast<std::size_t>(later - onsets.samples.begin()) - 1;
  }
  // After the last of several strikes all of them ring freely.
  const auto rings = [&](std::size_t k) {
    return (k + 1 < onsets.samples.size() ? onsets.samples[k + 1] : samples.size()) -
           onsets.samples[k];
  };
  onsets.taken = onsets.loudest;
  while (onsets.taken + 1 < onsets.samples.size() && rings(onsets.taken) < seconds(group_time) &&
         rings(onsets.taken + 1) > rings(onsets.taken)) {
    ++onsets.taken;
  }
  return onsets;
}

/// "0.020 s", "0.020 and 0.032 s" or "0.020, 0.032 and 0.051 s".
std::string times(std::span<const std::size_t> samples, double sample_rate) {
  std::string text;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (k > 0) text += k + 1 < samples.size() ? ", " : " and ";
    text += fmt::format("{:.3f}", static_cast<double>(samples[k]) / sample_rate);
  }
  return text + " s";
}

/// Sets the onset of a segment and where it ends for another strike's sake.
/// @return  where the strike itself begins: an onset that is given may be early
std::size_t choose_strike(const Onsets& onsets, std::optional<double> given, double sample_rate,
                          std::size_t frame, Segment& segment) {
  const std::span<const std::size_t> all = onsets.samples;
  std::size_t next = onsets.taken + 1;  // the strike after the one that is analysed
  std::size_t struck = all[onsets.taken];
  if (given) {
    struck = static_cast<std::size_t>(std::llround(*given * sample_rate));
    segment.onset = struck;
    const auto apart = [&](std::size_t strike) {
      return (static_cast<double>(all[strike]) / sample_rate) - *given;
    };
    for (next = 0; next < all.size() && apart(next) <= same_strike;) ++next;
    // A label may be early, unless there is a strike where it says.
    const bool labelled = next > 0 && apart(next - 1) > -same_strike;
    if (!labelled && next < all.size() && apart(next) < given_window) struck = all[next++];
  } else {
    segment.onset = struck;
    if (onsets.taken > onsets.loudest) {
      segment.remarks.push_back(fmt::format(
          "strikes at {}: analysed from the last on, where all of them ring; amplitudes are those "
          "of their sum (--onset takes another)",
          times(all.subspan(onsets.loudest, next - onsets.loudest), sample_rate)));
    } else if (onsets.taken > 0) {
      segment.remarks.push_back(
          fmt::format("struck before, at {}: the loudest strike, at {}, is analysed (--onset takes "
                      "another)",
                      times(all.first(onsets.taken), sample_rate),
                      times(all.subspan(onsets.taken, 1), sample_rate)));
    }
  }
  if (next < all.size()) {
    segment.end = all[next] - std::min(all[next], frame);
    segment.remarks.push_back(
        fmt::format("another strike or lost samples at {}: what comes after is left out",
                    times(all.subspan(next, 1), sample_rate)));
  }
  return struck;
}

/// Leaves out what is missing and what is clipped or limited.
void leave_out_damage(std::span<const double> samples, double sample_rate, std::size_t struck,
                      Segment& segment) {
  if (const auto gap = find_gap(samples.subspan(0, segment.end), struck, sample_rate)) {
    if (gap->breaks_off) {
      segment.remarks.push_back(
          fmt::format("samples are missing from {} on: what comes after is left out",
                      times({&gap->first, 1}, sample_rate)));
    }
    segment.end = gap->first;
  }
  const Clipping clipping = find_clipping(samples, segment.onset, segment.end);
  segment.clipped = clipping.count;
  if (clipping.last > segment.begin) {
    segment.begin = clipping.last + 1;
    segment.remarks.push_back(fmt::format(
        "{} samples are clipped: left out up to {:.1f} ms after the onset", clipping.count,
        1e3 * static_cast<double>(segment.begin - segment.onset) / sample_rate));
  } else if (clipping.count > 0) {
    segment.remarks.push_back(fmt::format("{} samples are clipped", clipping.count));
  } else if (const auto last = limited_until(samples, segment.onset, segment.end);
             last && *last > segment.begin) {
    segment.begin = *last;
    segment.remarks.push_back(fmt::format(
        "tops are limited, or were clipped at another sample rate: left out up to {:.1f} ms after "
        "the onset",
        1e3 * static_cast<double>(segment.begin - segment.onset) / sample_rate));
  }
}

}  // namespace

Segment find_segment(std::span<const double> samples, double sample_rate,
                     std::optional<double> onset, double contact) {
  Segment segment;
  segment.end = samples.size();
  const auto frame = std::max<std::size_t>(1, static_cast<std::size_t>(frame_length * sample_rate));
  if (samples.size() < 16 * frame) {
    segment.nothing =
        fmt::format("too short: {} sample{}", samples.size(), samples.size() == 1 ? "" : "s");
    return segment;
  }
  const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
  if (*high - *low < silent) {
    segment.nothing =
        std::max(std::abs(*low), std::abs(*high)) < silent ? "silent" : "constant: nothing moves";
    return segment;
  }
  if (onset && *onset * sample_rate >= static_cast<double>(samples.size())) {
    segment.nothing = fmt::format("the onset given, {:g} s, is after its end", *onset);
    return segment;
  }
  const Onsets onsets = find_onsets(samples, sample_rate, frame);
  const std::size_t struck = choose_strike(onsets, onset, sample_rate, frame, segment);
  segment.quiet = std::min(onsets.samples.front(), segment.onset);
  segment.begin = struck + static_cast<std::size_t>(contact * sample_rate);
  leave_out_damage(samples, sample_rate, struck, segment);
  if (segment.begin + 16 * frame > segment.end) {
    const double rings = static_cast<double>(segment.end) - static_cast<double>(struck);
    segment.nothing = segment.clipped > 0 ? "clipped to the end"
                                          : fmt::format("too short: {:.1f} ms after the strike",
                                                        1e3 * rings / sample_rate);
  }
  return segment;
}

}  // namespace carillon::eval::features
