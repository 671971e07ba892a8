// Whole scenes against what physics says of them.
#include <gtest/gtest.h>

#include <cmath>

#include "synth/room/detail/reverberation_time.hpp"
#include "tests/scene/heard_scene.hpp"

namespace carillon::scene {
namespace {

constexpr double audio_rate = 16000;
const std::string audio = "audio: {seconds: 1, sample_rate: 16000}\n";

double energy(std::span<const float> clip, double from = 0) {
  double sum = 0;
  for (std::size_t n = static_cast<std::size_t>(from * audio_rate); n < clip.size(); ++n) {
    sum += double(clip[n]) * clip[n];
  }
  return sum;
}

std::string listener(double distance) {
  return "listeners:\n  - position: [0, 0, " + std::to_string(distance) + "]\n";
}

TEST(ScenePhysics, PressureFallsWithDistanceAndComesLater) {
  const std::string far_field =
      "radiation: {min_sources: 60, max_sources: 60}\neffects: {click: off}\n";
  const Heard near = hear(audio + listener(2) + far_field, effects(), 1);
  const Heard far = hear(audio + listener(4) + far_field, effects(), 1);
  EXPECT_NEAR(std::sqrt(energy(near.audio) / energy(far.audio)), 2, 0.02);
  const auto first = [](const Heard& heard) {
    std::size_t n = 0;
    while (n < heard.audio.size() && heard.audio[n] == 0) ++n;
    return static_cast<double>(n) / audio_rate;
  };
  EXPECT_NEAR(first(far) - first(near), 2 / 343.0, 1.5 / audio_rate);
}

TEST(ScenePhysics, SupportsTakeEnergyAndNeverGiveAny) {
  double last = energy(hear(audio, effects(), 1).audio);
  const double late = energy(hear(audio, effects(), 1).audio, 0.3);
  for (const char* force : {"0.1 N", "1 N", "10 N"}) {
    const Heard held = hear(
        audio + "supports: {contacts: [{kind: finger, at: [0, 5 cm, 0], force: " + force + "}]}\n",
        effects(), 1);
    EXPECT_LT(energy(held.audio), last) << force;
    EXPECT_LT(energy(held.audio, 0.3), late) << force;
    last = energy(held.audio);
  }
}

// A dead object: what is heard late is the room.
TEST(ScenePhysics, RoomsDecayAsLongAsTheyWereAskedTo) {
  const std::string dead =
      "youngs_modulus=7e10,poisson_ratio=0.2,density=2500,alpha1=4000,alpha2=0";
  const std::string room =
      "radiation: {model: monopole}\n"
      "room: {dimensions: [6, 5, 4], source: [2, 2, 1.5], rt60: ";
  for (const double rt60 : {0.4, 0.8}) {
    const Heard wet =
        hear(audio + listener(1.5) + room + std::to_string(rt60) + "}\n", effects(), 1, dead);
    const std::vector<double> response(wet.audio.begin(), wet.audio.end());
    // Of the octave of most modes; air and walls are flat enough for it.
    const auto fit = synth::room::reverberation_time(
        synth::room::octave_band(response, audio_rate, 2000), audio_rate, 20);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->rt60, rt60, 0.15 * rt60);
  }
}

TEST(ScenePhysics, NoiseHasTheRecordedRatio) {
  const Heard clean = hear(audio, effects(), 1);
  const Heard noisy = hear(audio + "noise: {kind: white, snr: [3 dB, 20 dB]}\n", effects(), 1);
  const auto begin =
      static_cast<std::size_t>(noisy.record.at("active_begin").get<double>() * audio_rate);
  const auto end =
      static_cast<std::size_t>(noisy.record.at("active_end").get<double>() * audio_rate);
  double signal = 0, noise = 0;
  for (std::size_t n = begin; n < end; ++n) {
    signal += double(clean.audio[n]) * clean.audio[n];
    const double added = double(noisy.audio[n]) - clean.audio[n];
    noise += added * added;
  }
  EXPECT_NEAR(10 * std::log10(signal / noise), noisy.record.at("noise_ratio").get<double>(), 0.01);
}

// Twice is 6.02 dB, whatever came before.
TEST(ScenePhysics, RecordersGainIsInDecibels) {
  const std::string scene = audio + listener(1) +
                            "radiation: {model: monopole}\n"
                            "room: {dimensions: [6, 5, 4], source: [2, 2, 1.5], rt60: 0.4}\n";
  const Heard once = hear(scene, effects(), 1);
  const Heard louder = hear(scene + "recording: {gain: 6.0205999 dB}\n", effects(), 1);
  for (std::size_t n = 0; n < once.audio.size(); n += 7) {
    ASSERT_NEAR(louder.audio[n], 2 * once.audio[n], 1e-5 * std::abs(once.audio[n]) + 1e-12) << n;
  }
}

}  // namespace
}  // namespace carillon::scene
