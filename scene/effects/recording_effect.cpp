#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/numbers.hpp"
#include "core/random.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"
#include "synth/recording/band_limits.hpp"
#include "synth/recording/codec.hpp"
#include "synth/recording/recording_chain.hpp"

namespace carillon::scene {

namespace {

// Measured by scripts/bench noise: dithered rounding of 1 s at 44.1 kHz, and a shift by fractions.
constexpr double seconds_per_sample = 0.25e-3 / 44100;
constexpr double seconds_per_sample_shifted = 3.2e-3 / 44100;
constexpr double seconds_per_sample_cut = 0.2e-3 / 44100;      ///< each of the two limits
constexpr double seconds_per_sample_encoded = 8.3e-3 / 44100;  ///< mean of the codecs

constexpr double fade_seconds = 5e-3;  ///< at the end of a clip that stops

/// What a recorder does to a sound.
struct Recorder {
  core::Range shift;                             ///< [s]
  bool fractions = false;                        ///< of samples, in shifts
  std::optional<core::Range> low_cut, high_cut;  ///< [Hz]
  core::Range gain;                              ///< [dB]
  std::optional<core::Range> peak;               ///< against full scale [dB], in place of gain
  std::optional<double> clip;
  int bits = 0;  ///< 0: not quantised
  bool dither = false;
  std::vector<synth::recording::Codec> codecs;  ///< one is drawn; none: no column
  core::Range compression;
  std::optional<core::Range> length;  ///< after the sound began [s]
};

std::optional<core::Range> read_edge(core::ConfigNode& node, const char* key, double sample_rate) {
  if (!node.has(key)) return {};
  const core::Range edge = node.range(key, core::Dimension::frequency);
  if (!(edge.low > 0 && edge.high < sample_rate / 2)) {
    node.fail(key, "must lie above 0 and below half the sample rate");
  }
  return edge;
}

void read_codec(core::ConfigNode& node, Recorder& recorder) {
  const std::vector<std::string>& names = synth::recording::codec_names();
  for (const std::string& name : node.texts("codec", std::vector<std::string>{})) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      node.fail("codec", fmt::format("unknown value \"{}\"", name),
                fmt::format("one or more of {}", fmt::join(names, ", ")));
    }
    recorder.codecs.push_back(static_cast<synth::recording::Codec>(found - names.begin()));
  }
  recorder.compression = node.range("compression", core::Dimension::none, core::Range{0.3, 0.3});
  constexpr double highest = synth::recording::max_compression;
  if (recorder.compression.low < 0 || recorder.compression.high > highest) {
    node.fail("compression", fmt::format("must lie within 0 and {}", highest));
  }
}

Recorder read_recorder(core::ConfigNode& node, double sample_rate) {
  Recorder recorder;
  recorder.shift = node.range("shift", core::Dimension::time, core::Range{0, 0});
  if (recorder.shift.low < 0) {
    node.fail("shift", "a sound can only come later", "times from 0 s");
  }
  recorder.fractions = node.flag("shift_fractions", false);
  if (node.has("peak")) {
    if (node.has("gain")) node.fail("peak", "decides the gain", "give one of `gain` and `peak`");
    recorder.peak = node.range("peak", core::Dimension::level);
  } else {
    recorder.gain = node.range("gain", core::Dimension::level, core::Range{0, 0});
    if (recorder.gain.low < -200 || recorder.gain.high > 200) {
      node.fail("gain", "gains beyond 200 dB are not possible", "-200 to 200 dB");
    }
  }
  recorder.low_cut = read_edge(node, "low_cut", sample_rate);
  recorder.high_cut = read_edge(node, "high_cut", sample_rate);
  if (node.has("clip")) {
    recorder.clip = node.quantity("clip", core::Dimension::none);
    if (!(*recorder.clip > 0)) node.fail("clip", "the level must be positive", "1 is full scale");
  }
  recorder.bits = static_cast<int>(node.integer("bits", 0, 24, 0));
  if (recorder.bits == 1) {
    node.fail("bits", "one bit has no step between silence and full scale",
              "2 to 24 bits, or 0 for none");
  }
  recorder.dither = node.flag("dither", false);
  if (recorder.dither && recorder.bits == 0) {
    node.fail("dither", "dither belongs to a number of bits", "give `bits`, or leave it out");
  }
  read_codec(node, recorder);
  if (node.has("length")) {
    recorder.length = node.range("length", core::Dimension::time);
    if (!(recorder.length->low > 0)) node.fail("length", "must be positive");
  }
  return recorder;
}

/// How much later a sound comes [samples].
double random_shift(const Recorder& recorder, const Sound& sound) {
  core::RandomStream random(sound.seed, sound.id, "recording.shift");
  const double samples =
      random.uniform(recorder.shift.low, recorder.shift.high) * sound.sample_rate;
  return recorder.fractions ? samples : std::round(samples);
}

/// Before noise is added, so that the noise is there before the sound.
void shift(const Recorder& recorder, Sound& sound) {
  const double samples = random_shift(recorder, sound);
  for (std::size_t row = 0; row < sound.rows; ++row)
    synth::recording::shift_later(sound.row(row), samples);
  if (sound.record != nullptr) {
    sound.record->add("recording_shift", samples / sound.sample_rate);
  }
}

/// The microphone's limits.
void limit_band(const Recorder& recorder, Sound& sound) {
  core::RandomStream random(sound.seed, sound.id, "recording.band");
  const auto cut = [&](const std::optional<core::Range>& range, const char* column, auto filter) {
    if (!range) return;
    const double edge = random.log_uniform(range->low, range->high);
    for (std::size_t row = 0; row < sound.rows; ++row)
      filter(sound.row(row), edge, sound.sample_rate);
    if (sound.record != nullptr) sound.record->add(column, edge);
  };
  cut(recorder.low_cut, "recording_low_cut", synth::recording::cut_below);
  cut(recorder.high_cut, "recording_high_cut", synth::recording::cut_above);
}

/// What the level was set by [dB]; 0 for a silent clip that was to have a peak.
double gain_of(const Recorder& recorder, const Sound& sound) {
  core::RandomStream random(sound.seed, sound.id, "recording.gain");
  if (!recorder.peak) return random.uniform(recorder.gain.low, recorder.gain.high);
  double loudest = 0;
  for (const float sample : sound.audio) loudest = std::max(loudest, std::abs(double{sample}));
  if (loudest == 0) return 0;
  return random.uniform(recorder.peak->low, recorder.peak->high) - 20 * std::log10(loudest);
}

/// The file, and where it ends.
void keep(const Recorder& recorder, Sound& sound) {
  core::RandomStream random(sound.seed, sound.id, "recording.file");
  if (!recorder.codecs.empty()) {
    const synth::recording::Codec codec = recorder.codecs[random.index(recorder.codecs.size())];
    const double compression = random.uniform(recorder.compression.low, recorder.compression.high);
    for (std::size_t row = 0; row < sound.rows; ++row) {
      synth::recording::pass_through(codec, compression, sound.row(row), sound.sample_rate);
    }
    if (sound.record != nullptr) {
      sound.record->add("recording_codec",
                        synth::recording::codec_names()[static_cast<std::size_t>(codec)]);
      sound.record->add("recording_compression",
                        codec == synth::recording::Codec::none ? core::nan : compression);
    }
  }
  if (!recorder.length) return;
  const double length = random.log_uniform(recorder.length->low, recorder.length->high);
  const double began = random_shift(recorder, sound);
  for (std::size_t row = 0; row < sound.rows; ++row) {
    synth::recording::stop_at(sound.row(row), began + length * sound.sample_rate,
                              fade_seconds * sound.sample_rate);
  }
  if (sound.record != nullptr) sound.record->add("recording_length", length);
}

void convert(const Recorder& recorder, core::SampleFormat format, Sound& sound) {
  limit_band(recorder, sound);
  const double gain = gain_of(recorder, sound);
  if (gain != 0) synth::recording::apply_gain(sound.audio, gain);
  std::size_t beyond = recorder.clip ? synth::recording::clip_at(sound.audio, *recorder.clip) : 0;
  if (recorder.bits > 0) {
    core::RandomStream dither(sound.seed, sound.id, "recording.dither");
    beyond +=
        synth::recording::quantise(sound.audio, recorder.bits, recorder.dither ? &dither : nullptr);
  }
  keep(recorder, sound);
  // Of the clip as it is stored.
  const bool silent = format == core::SampleFormat::int16
                          ? synth::recording::silent_after_rounding(sound.audio, 16)
                          : std::all_of(sound.audio.begin(), sound.audio.end(),
                                        [](float sample) { return sample == 0; });
  if (sound.record == nullptr) return;
  sound.record->add("recording_gain", gain);
  sound.record->add("recording_clipped", static_cast<std::int64_t>(beyond));
  sound.record->add("recording_bits", static_cast<std::int64_t>(recorder.bits));
  sound.record->add("recording_silent", static_cast<std::int64_t>(silent));
}

/// Of sounds that a codec alters.
double encoded_fraction(const Recorder& recorder) {
  if (recorder.codecs.empty()) return 0;
  const auto kept =
      std::count(recorder.codecs.begin(), recorder.codecs.end(), synth::recording::Codec::none);
  return 1 - static_cast<double>(kept) / static_cast<double>(recorder.codecs.size());
}

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  if (!root.has("recording")) {
    effect.reason_off = "no recording:";
    return effect;
  }
  core::ConfigNode node = root.child("recording");
  const Recorder recorder = read_recorder(node, scene.audio.sample_rate);
  effect.asked_by = "recording: (" + root.where("recording") + ")";
  const bool sinc = recorder.fractions && recorder.shift.high > 0;
  effect.seconds_per_sound = static_cast<double>(scene.audio.samples()) *
                             (seconds_per_sample + (sinc ? seconds_per_sample_shifted : 0) +
                              (recorder.low_cut ? seconds_per_sample_cut : 0) +
                              (recorder.high_cut ? seconds_per_sample_cut : 0) +
                              encoded_fraction(recorder) * seconds_per_sample_encoded);
  effect.start = [recorder, format = scene.audio.dtype](const std::filesystem::path&) {
    EffectParts parts;
    if (recorder.shift.high > 0) {
      parts.audio = [recorder](Sound& sound) { shift(recorder, sound); };
    }
    parts.full_scale = [recorder, format](Sound& sound) { convert(recorder, format, sound); };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect recording_effect = {
    .name = "recording",
    .description = "time shift, band limits, gain, clipping, bit depth and codec of a recorder",
    .key = "recording",
    .stage = "full scale",
    .read = read};

}  // namespace carillon::scene
