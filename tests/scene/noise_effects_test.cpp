// Noise and recorder as a configuration asks for them, on a sound made by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "../synth/sound_files.hpp"
#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "scene/columns.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"

namespace carillon::scene {
namespace {

constexpr double rate = 16000;

Scene scene(core::SampleFormat format = core::SampleFormat::float32) {
  Scene made;
  made.file_name = "scene.yaml";
  made.audio.sample_rate = rate;
  made.audio.dtype = format;
  return made;
}

SceneEffect read(const Effect& effect, const std::string& text, const Scene& in = scene()) {
  core::ConfigNode root = core::ConfigNode::parse(text, in.file_name);
  SceneEffect made = effect.read(root, in);
  root.finish();
  return made;
}

/// Two rows of a decay of 0.12 s that begins after 0.1 s.
Sound decay(core::Columns* record = nullptr, std::uint64_t id = 1) {
  Sound sound;
  sound.seed = 5;
  sound.id = id;
  sound.sample_rate = rate;
  sound.rows = 2;
  sound.record = record;
  sound.rings.readout.unit = "Pa";
  sound.audio.assign(2 * 16000, 0.0F);
  for (std::size_t i = 1600; i < 16000; ++i) {
    const double t = static_cast<double>(i - 1600) / rate;
    const double value = 0.5 * std::exp(-57.6 * t) * std::cos(6283 * t);
    sound.audio[i] = static_cast<float>(value);
    sound.audio[16000 + i] = static_cast<float>(0.3 * value);
  }
  return sound;
}

double measured_ratio(const Sound& clean, const Sound& noisy, std::size_t begin, std::size_t end) {
  double signal = 0, noise = 0;
  for (std::size_t row = 0; row < 2; ++row) {
    for (std::size_t i = row * 16000 + begin; i < row * 16000 + end; ++i) {
      signal += std::pow(double(clean.audio[i]), 2);
      noise += std::pow(double(noisy.audio[i]) - clean.audio[i], 2);
    }
  }
  return 10 * std::log10(signal / noise);
}

void expect_recorded_ratio(const SceneEffect& effect, std::size_t part = 0, std::size_t parts = 1) {
  const EffectParts working = effect.start("");
  for (std::uint64_t id = 0; id < 10; ++id) {
    core::Columns record(columns());
    const Sound clean = decay();
    Sound noisy = decay(&record, id);
    noisy.part = part;
    noisy.parts = parts;
    working.audio(noisy);
    const auto row = record.last_row();
    const double ratio = row.at("noise_ratio");
    EXPECT_GE(ratio, 3);
    EXPECT_LT(ratio, 30);
    const auto begin = std::size_t(std::lround(row.at("active_begin").get<double>() * rate));
    const auto end = std::size_t(std::lround(row.at("active_end").get<double>() * rate));
    EXPECT_EQ(begin, 1600u);
    EXPECT_NEAR(double(end - begin) / rate, std::log(1000) / 57.6, 2e-3);
    EXPECT_NEAR(measured_ratio(clean, noisy, begin, end), ratio, 1e-3);
    // Independent in the two rows, and there before the sound.
    double product = 0, first = 0, second = 0;
    for (std::size_t i = 0; i < 1600; ++i) {
      const double a = noisy.audio[i], b = noisy.audio[16000 + i];
      product += a * b, first += a * a, second += b * b;
    }
    EXPECT_GT(first, 0);
    EXPECT_LT(std::abs(product) / std::sqrt(first * second), 0.3);
    // The same again, whatever came before.
    Sound again = decay(nullptr, id);
    again.part = part;
    again.parts = parts;
    working.audio(again);
    EXPECT_EQ(again.audio, noisy.audio);
  }
}

TEST(NoiseEffect, AddsGeneratedNoiseAtTheRecordedRatio) {
  expect_recorded_ratio(read(noise_effect, "noise: {kind: white, snr: [3 dB, 30 dB]}\n"));
  expect_recorded_ratio(read(noise_effect, "noise: {kind: [white, white], snr: [3, 30]}\n"));
}

TEST(NoiseEffect, AddsRecordedNoiseAtTheRecordedRatio) {
  const core::TemporaryFolder folder;
  for (unsigned i = 0; i < 3; ++i) {
    synth::write_sound(folder / (std::to_string(i) + ".wav"), synth::some_noise(44100, i), 44100);
  }
  const std::string text = "noise: {folder: " + folder.path().string() + ", snr: [3 dB, 30 dB]}\n";
  const SceneEffect effect = read(noise_effect, text);
  const std::string content = effect.content();
  EXPECT_FALSE(content.empty());
  expect_recorded_ratio(effect);
  expect_recorded_ratio(effect, 2, 9);
  synth::write_sound(folder / "more.wav", synth::some_noise(44100, 9), 44100);
  EXPECT_NE(read(noise_effect, text).content(), content);
}

TEST(NoiseEffect, LeavesASilentClipAloneAndSaysSo) {
  const EffectParts working = read(noise_effect, "noise: {kind: pink}\n").start("");
  core::Columns record(columns());
  Sound sound = decay(&record);
  std::fill(sound.audio.begin(), sound.audio.end(), 0.0F);
  working.audio(sound);
  EXPECT_EQ(sound.audio, std::vector<float>(32000, 0.0F));
  const auto row = record.last_row();
  EXPECT_EQ(row.at("noise_level"), 0.0);
  EXPECT_EQ(row.at("active_end"), 0.0);
  const auto& ratio = row.at("noise_ratio");
  EXPECT_TRUE(ratio.is_null() || std::isnan(ratio.get<double>()));
}

TEST(NoiseEffect, SaysWhatAsksForIt) {
  EXPECT_EQ(read(noise_effect, "{}\n").reason_off, "no noise:");
  EXPECT_EQ(read(recording_effect, "{}\n").reason_off, "no recording:");
  EXPECT_EQ(read(noise_effect, "\nnoise: {kind: hum}\n").asked_by, "noise: (scene.yaml:2)");
  EXPECT_EQ(read(recording_effect, "recording: {}\n").asked_by, "recording: (scene.yaml:1)");
}

std::string refusal(const Effect& effect, const std::string& text) {
  try {
    read(effect, text);
    return "accepted";
  } catch (const core::ConfigError& error) {
    return error.message();
  }
}

TEST(NoiseEffect, RefusesWhatMakesNoModality) {
  const auto has = [](const std::string& text, const std::string& part) {
    EXPECT_NE(refusal(noise_effect, text).find(part), std::string::npos)
        << refusal(noise_effect, text);
  };
  has("noise: {kind: wite}\n", "did you mean \"white\"?");
  has("noise: {}\n", "noise needs `folder`");
  has("noise: {kind: white, folder: x}\n", "not both");
  has("noise: {kind: white, snr: 5 m}\n", "a level is wanted");
  has("noise: {kind: white, snr: [-200, 0]}\n", "single precision");
  has("noise: {kind: white, channel: 1}\n", "unknown key");
}

// An effect that is off looks at no file; one that is on finds faults when it is read.
TEST(NoiseEffect, LooksAtItsFolderOnlyWhenItIsOn) {
  const core::TemporaryFolder empty;
  const std::string path = empty.path().string();
  const Effect registry[] = {noise_effect};  // scenes point into it
  const auto scene_of = [&registry](const std::string& text) {
    core::ConfigNode root = core::ConfigNode::parse(text, "scene.yaml");
    return read_scene(root, "scene.yaml", registry);
  };
  EXPECT_FALSE(scene_of("noise: {folder: absent}\neffects: {noise: off}\n").runs("noise"));
  for (const std::string& folder : {std::string("absent"), path}) {
    try {
      scene_of("noise: {folder: " + folder + "}\n");
      ADD_FAILURE() << folder;
    } catch (const core::ConfigError& error) {
      EXPECT_NE(error.message().find("noise.folder"), std::string::npos) << error.message();
    }
  }
  synth::write_sound(empty / "short.wav", synth::some_noise(800, 1), 16000);
  EXPECT_THROW(scene_of("noise: {folder: " + path + "}\n"), core::ConfigError);
  synth::write_sound(empty / "long.wav", synth::some_noise(16000, 2), 16000);
  EXPECT_TRUE(scene_of("noise: {folder: " + path + "}\n").runs("noise"));
}

TEST(RecordingEffect, ShiftsBeforeAndConvertsAtFullScale) {
  const EffectParts working =
      read(recording_effect,
           "recording: {shift: [0.01 s, 0.05 s], gain: [6 dB, 12 dB], clip: 0.5, bits: 12, "
           "dither: true}\n")
          .start("");
  core::Columns record(columns());
  const Sound clean = decay();
  Sound sound = decay(&record);
  working.audio(sound);
  working.full_scale(sound);
  const auto row = record.last_row();
  const auto shift = std::size_t(std::lround(row.at("recording_shift").get<double>() * rate));
  EXPECT_GE(shift, 160u);
  EXPECT_LE(shift, 800u);
  const double gain = std::pow(10.0, row.at("recording_gain").get<double>() / 20);
  EXPECT_GE(gain, 1.99);
  EXPECT_LE(gain, 3.99);
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < sound.audio.size(); ++i) {
    const double moved = i % 16000 < shift ? 0 : gain * clean.audio[i - shift];
    beyond += std::abs(moved) > 0.5;
    // Rounding half a step and dither of one step.
    EXPECT_NEAR(sound.audio[i], std::clamp(moved, -0.5, 0.5), 1.5 / 2048) << i;
    EXPECT_EQ(std::fmod(double(sound.audio[i]), 1.0 / 2048), 0.0);
  }
  EXPECT_GT(beyond, 0u);
  EXPECT_EQ(row.at("recording_clipped"), beyond);
  EXPECT_EQ(row.at("recording_bits"), 12);
  EXPECT_EQ(row.at("recording_silent"), 0);
}

TEST(RecordingEffect, SetsThePeakLimitsTheBandAndStops) {
  const EffectParts working =
      read(recording_effect,
           "recording: {low_cut: 50 Hz, high_cut: [2 kHz, 3 kHz], peak: [-12 dB, -6 dB], "
           "codec: [mp3], compression: 0.2, length: 0.2 s, shift: 0.1 s}\n")
          .start("");
  core::Columns record(columns());
  Sound sound = decay(&record);
  working.audio(sound);
  working.full_scale(sound);
  const auto row = record.last_row();
  EXPECT_EQ(row.at("recording_low_cut"), 50);
  EXPECT_GE(row.at("recording_high_cut").get<double>(), 2000);
  EXPECT_LE(row.at("recording_high_cut").get<double>(), 3000);
  EXPECT_EQ(row.at("recording_codec"), "mp3");
  EXPECT_EQ(row.at("recording_length"), 0.2);
  float loudest = 0;
  const auto end = static_cast<std::size_t>(0.3 * rate);
  for (std::size_t i = 0; i < sound.row(0).size(); ++i) {
    loudest = std::max(loudest, std::abs(sound.row(0)[i]));
    if (i >= end) EXPECT_EQ(sound.row(0)[i], 0) << i;
  }
  EXPECT_GT(loudest, 0.2);  // -12 dB, the other row may be louder and the codec change it
  EXPECT_LT(loudest, 0.6);
  for (const char* wrong : {"gain: 1 dB, peak: 0 dB", "high_cut: 30 kHz", "low_cut: 0 Hz",
                            "codec: flac", "compression: 1", "length: 0 s"}) {
    EXPECT_THROW(read(recording_effect, std::string("recording: {") + wrong + "}\n"),
                 core::ConfigError)
        << wrong;
  }
}

TEST(RecordingEffect, TellsOfAnInt16ClipThatRoundsToNothing) {
  for (const auto format : {core::SampleFormat::int16, core::SampleFormat::float32}) {
    const EffectParts working =
        read(recording_effect, "recording: {gain: -100 dB}\n", scene(format)).start("");
    EXPECT_FALSE(working.audio);
    core::Columns record(columns());
    Sound sound = decay(&record);
    working.full_scale(sound);
    EXPECT_EQ(record.last_row().at("recording_silent"),
              format == core::SampleFormat::int16 ? 1 : 0);
  }
}

TEST(RecordingEffect, RefusesWhatMakesNoModality) {
  for (const char* text :
       {"recording: {shift: [-1 s, 0 s]}\n", "recording: {gain: 300 dB}\n",
        "recording: {clip: 0}\n", "recording: {bits: 1}\n", "recording: {bits: 25}\n",
        "recording: {dither: true}\n", "recording: {gian: 3 dB}\n"}) {
    EXPECT_NE(refusal(recording_effect, text), "accepted") << text;
  }
}

}  // namespace
}  // namespace carillon::scene
