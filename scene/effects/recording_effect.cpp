#include <algorithm>
#include <cmath>
#include <optional>

#include "core/random.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"
#include "synth/recording/recording_chain.hpp"

namespace carillon::scene {

namespace {

// Measured by scripts/bench noise: dithered rounding of 1 s at 44.1 kHz, and a shift by fractions.
constexpr double seconds_per_sample = 0.25e-3 / 44100;
constexpr double seconds_per_sample_shifted = 3.2e-3 / 44100;

/// What a recorder does to a sound.
struct Recorder {
  core::Range shift;       ///< [s]
  bool fractions = false;  ///< of samples, in shifts
  core::Range gain;        ///< [dB]
  std::optional<double> clip;
  int bits = 0;  ///< 0: not quantised
  bool dither = false;
};

Recorder read_recorder(core::ConfigNode& node) {
  Recorder recorder;
  recorder.shift = node.range("shift", core::Dimension::time, core::Range{0, 0});
  if (recorder.shift.low < 0) {
    node.fail("shift", "a sound can only come later", "times from 0 s");
  }
  recorder.fractions = node.flag("shift_fractions", false);
  recorder.gain = node.range("gain", core::Dimension::level, core::Range{0, 0});
  if (recorder.gain.low < -200 || recorder.gain.high > 200) {
    node.fail("gain", "gains beyond 200 dB are not possible", "-200 to 200 dB");
  }
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
  return recorder;
}

/// Before noise is added, so that the noise is there before the sound.
void shift(const Recorder& recorder, Sound& sound) {
  core::RandomStream random(sound.seed, sound.id, "recording.shift");
  double samples = random.uniform(recorder.shift.low, recorder.shift.high) * sound.sample_rate;
  if (!recorder.fractions) samples = std::round(samples);
  for (std::size_t row = 0; row < sound.rows; ++row)
    synth::recording::shift_later(sound.row(row), samples);
  if (sound.record != nullptr) {
    sound.record->add("recording_shift", samples / sound.sample_rate);
  }
}

void convert(const Recorder& recorder, core::SampleFormat format, Sound& sound) {
  core::RandomStream random(sound.seed, sound.id, "recording.gain");
  const double gain = random.uniform(recorder.gain.low, recorder.gain.high);
  if (gain != 0) synth::recording::apply_gain(sound.audio, gain);
  std::size_t beyond = recorder.clip ? synth::recording::clip_at(sound.audio, *recorder.clip) : 0;
  if (recorder.bits > 0) {
    core::RandomStream dither(sound.seed, sound.id, "recording.dither");
    beyond +=
        synth::recording::quantise(sound.audio, recorder.bits, recorder.dither ? &dither : nullptr);
  }
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

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  if (!root.has("recording")) {
    effect.reason_off = "no recording:";
    return effect;
  }
  core::ConfigNode node = root.child("recording");
  const Recorder recorder = read_recorder(node);
  effect.asked_by = "recording: (" + root.where("recording") + ")";
  const bool sinc = recorder.fractions && recorder.shift.high > 0;
  effect.seconds_per_sound =
      static_cast<double>(scene.audio.samples()) *
      (sinc ? seconds_per_sample_shifted + seconds_per_sample : seconds_per_sample);
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
    .description = "time shift, gain, clipping and bit depth of a recorder",
    .key = "recording",
    .stage = "full scale",
    .read = read};

}  // namespace carillon::scene
