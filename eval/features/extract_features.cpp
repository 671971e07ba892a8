#include "eval/features/extract_features.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/features/detail/features_by_tones.hpp"
#include "eval/features/detail/find_tones.hpp"
#include "eval/features/detail/reverberation.hpp"
#include "eval/features/detail/sounding_end.hpp"
#include "eval/features/detail/spectrogram_peaks.hpp"
#include "eval/features/segment.hpp"

namespace carillon::eval::features {

namespace {

using core::InputError;

constexpr double max_time = 1e6;  ///< of times that are given [s]

/// The segment from where the room has decayed by 20 dB.
Segment late_segment(const Segment& segment, double sample_rate, const FeatureOptions& options) {
  const double wait = core::median(options.rt60) / 3 * sample_rate;
  Segment late = segment;
  const auto left = static_cast<double>(segment.end - segment.onset);
  late.begin =
      std::max(segment.begin, segment.onset + static_cast<std::size_t>(std::min(wait, left)));
  return late;
}

/// What of a recording is analysed for a segment.
SoundPart part_of(std::span<const double> samples, const Segment& segment, double sample_rate,
                  const FeatureOptions& options) {
  const auto longest_end = static_cast<double>(segment.begin) + options.duration * sample_rate;
  const std::size_t end =
      std::min(segment.end, static_cast<std::size_t>(std::min(longest_end, 1e15)));
  SoundPart part;
  part.quiet = samples.first(segment.quiet);
  if (segment.begin < end) {
    const auto rest = samples.subspan(segment.begin, end - segment.begin);
    part.samples = rest.first(largest_fft_size(sounding_end(rest, part.quiet, sample_rate)));
  }
  part.after_onset = static_cast<double>(segment.begin - segment.onset);
  part.unheard = part.after_onset;
  return part;
}

/// Modes in the late part of the sound that are not the room's.
std::vector<Feature> modes_after_room(const SoundPart& sound, double sample_rate,
                                      const FeatureOptions& options, FeatureSet& set) {
  FeatureSet late;
  if (!sound.samples.empty()) features_by_tones(sound, sample_rate, options, late);
  const Late part{sound.after_onset / sample_rate,
                  static_cast<double>(sound.samples.size()) / sample_rate};
  const double needed = time_to_stand_out(std::log(1000.0) / core::median(options.rt60));
  if (part.length < needed) {
    set.remarks.push_back(
        fmt::format("too short to tell modes from the room: they must be heard until {:.2f} s "
                    "after the onset at least",
                    part.begin + needed));
  }
  if (!options.keep_reverberant) {
    set.explained = late.explained;
    set.hums = std::move(late.hums);
    set.residual = std::move(late.residual);
  }
  return outlasting(late.features, part, options.rt60);
}

}  // namespace

double highest_mode(double sample_rate, const FeatureOptions& options) {
  return std::min(options.max_frequency, highest_frequency * sample_rate);
}

void check_extraction(std::span<const double> samples, double sample_rate,
                      const FeatureOptions& options) {
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw InputError(fmt::format("a sample rate of {} Hz", sample_rate), "it must be positive");
  }
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if (!std::isfinite(samples[n])) {
      throw InputError(fmt::format("sample {} (at {:.4f} s) is {}", n,
                                   static_cast<double>(n) / sample_rate, samples[n]),
                       "cut the recording there, or export it again");
    }
  }
  const auto require = [](bool holds, const char* text) {
    if (!holds) throw InputError(text);
  };
  const auto is_time = [](double time) { return time >= 0 && time < max_time; };
  require(is_time(options.contact_time), "contact_time must be from 0 to 1e6 s");
  require(options.min_decay_rate.value_or(0) >= 0, "min_decay_rate must not be negative");
  require(options.min_frequency > 0, "min_frequency must be positive");
  require(options.max_frequency > options.min_frequency,
          "max_frequency must lie above min_frequency");
  require(!options.onset || is_time(*options.onset), "the onset must be from 0 to 1e6 s");
  require(std::all_of(options.rt60.begin(), options.rt60.end(), is_time),
          "reverberation times (rt60) must be from 0 to 1e6 s");
  require(options.duration > 0, "the duration must be positive");
  require(options.explained > 0 && options.explained <= 1,
          "the explained fraction must be above 0, and 1 at most");
  if (options.min_frequency > highest_frequency * sample_rate) {
    throw InputError(
        fmt::format("no mode can lie above {:g} Hz in a recording of {:g} Hz",
                    options.min_frequency, sample_rate),
        fmt::format("a least frequency below {:g} Hz", highest_frequency * sample_rate));
  }
}

FeatureSet set_of_segment(const Segment& segment, double sample_rate) {
  FeatureSet set;
  set.sample_rate = sample_rate;
  set.onset = static_cast<double>(segment.onset) / sample_rate;
  set.begin = static_cast<double>(segment.begin) / sample_rate;
  set.end = static_cast<double>(segment.end) / sample_rate;
  set.clipped = segment.clipped;
  set.remarks = segment.remarks;
  set.nothing = segment.nothing;
  return set;
}

FeatureSet extract_features(std::span<const double> samples, double sample_rate,
                            const FeatureOptions& options) {
  check_extraction(samples, sample_rate, options);
  const Segment segment = find_segment(samples, sample_rate, options.onset, options.contact_time);
  FeatureSet set = set_of_segment(segment, sample_rate);
  if (!set.nothing.empty()) return set;

  const SoundPart part = part_of(samples, segment, sample_rate, options);
  set.end = set.begin + static_cast<double>(part.samples.size()) / sample_rate;
  if (options.method == FeatureMethod::peaks) {
    by_peaks(part.samples, sample_rate, part.after_onset, options, set);
    if (!options.rt60.empty()) mark_faster(options.rt60, set.features);
  } else {
    const bool in_room = reverberates(options.rt60);
    if (!in_room || options.keep_reverberant) features_by_tones(part, sample_rate, options, set);
    if (in_room) {
      const Segment late = late_segment(segment, sample_rate, options);
      SoundPart late_part = part_of(samples, late, sample_rate, options);
      late_part.unheard = part.unheard;
      const auto modes = modes_after_room(late_part, sample_rate, options, set);
      if (!options.keep_reverberant) set.begin = static_cast<double>(late.begin) / sample_rate;
      set.features = replaced_by(modes, std::move(set.features), options.rt60);
    }
  }
  const auto by_frequency = [](const auto& a, const auto& b) { return a.frequency < b.frequency; };
  std::sort(set.features.begin(), set.features.end(), by_frequency);
  std::sort(set.hums.begin(), set.hums.end(), by_frequency);
  if (set.features.empty()) {
    set.nothing = !set.hums.empty()          ? "only steady tones"
                  : options.keep_reverberant ? "no decaying tone above the noise"
                                             : "no decaying tone above the noise and the room";
  }
  return set;
}

}  // namespace carillon::eval::features
