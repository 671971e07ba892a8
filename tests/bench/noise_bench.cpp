// Processor time of noise and recorder for a clip of one second at 44.1 kHz. Prints the table of
// docs/sound/noise.md.
#include <fmt/core.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>

#include "core/audio.hpp"
#include "synth/recording/band_limits.hpp"
#include "synth/recording/codec.hpp"
#include "synth/recording/noise_generators.hpp"
#include "synth/recording/noise_recordings.hpp"
#include "synth/recording/recording_chain.hpp"
#include "synth/recording/signal_to_noise.hpp"

namespace carillon::bench {
namespace {

constexpr std::size_t count = 44100;
constexpr double rate = 44100;

/// Least of five means of twenty runs: other programs do not count, nor do cold caches.
void time(const std::string& name, const std::function<void(std::uint64_t)>& work) {
  double minimum = 1e9;
  std::uint64_t item = 0;
  for (int round = 0; round < 5; ++round) {
    const std::clock_t begin = std::clock();
    for (int run = 0; run < 20; ++run) work(++item);
    minimum = std::min(minimum, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / 20);
  }
  fmt::print("{:32} {:8.3f} ms\n", name, 1e3 * minimum);
}

void run(const std::filesystem::path& folder) {
  double kept = 0;  // so that nothing is optimised away
  for (const std::string& name : synth::recording::noise_kind_names()) {
    time(name, [&](std::uint64_t item) {
      core::RandomStream random(1, item, "bench");
      kept += synth::recording::generate_noise(synth::recording::noise_kind(name), count, rate,
                                               random)[7];
    });
  }
  if (!folder.empty()) {
    synth::recording::NoiseFolder noise(folder, {});
    const std::clock_t begin = std::clock();
    for (std::uint64_t item = 0; item < 200; ++item) {
      core::RandomStream random(1, item, "bench");
      kept += noise.draw(count, 0, 1, random).samples[7];
    }
    fmt::print("{:32} {:8.3f} ms\n", "first draws from a folder, each",
               1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / 200);
    time("draw from a folder", [&](std::uint64_t item) {
      core::RandomStream random(1, item, "bench");
      kept += noise.draw(count, 0, 1, random).samples[7];
    });
  }
  std::vector<float> clip(count);
  for (std::size_t i = 0; i < count; ++i) {
    clip[i] = static_cast<float>(std::exp(-20 * static_cast<double>(i) / rate));
  }
  core::RandomStream random(1, 2, "bench");
  const auto noise =
      synth::recording::generate_noise(synth::recording::NoiseKind::white, count, rate, random);
  time("active part and sum", [&](std::uint64_t) {
    auto copy = clip;
    kept += synth::recording::add_noise(copy, noise, 1,
                                        synth::recording::active_part(copy, 1, rate), 20);
  });
  time("shift by whole samples", [&](std::uint64_t item) {
    auto copy = clip;
    synth::recording::shift_later(copy, static_cast<double>(item));
    kept += copy[100];
  });
  time("shift by fractions", [&](std::uint64_t item) {
    auto copy = clip;
    synth::recording::shift_later(copy, static_cast<double>(item) + 0.3);
    kept += copy[100];
  });
  time("16 bits with dither", [&](std::uint64_t item) {
    auto copy = clip;
    core::RandomStream dither(1, item, "bench");
    kept += static_cast<double>(synth::recording::quantise(copy, 16, &dither));
  });
  // A strike behind noise 40 dB below it, which codecs spend more on than on silence.
  for (std::size_t i = 0; i < count; ++i) {
    clip[i] = static_cast<float>(0.5 * clip[i] * std::sin(0.3 * static_cast<double>(i)) +
                                 0.005 * noise[i]);
  }
  time("upper limit", [&](std::uint64_t) {
    auto copy = clip;
    synth::recording::cut_above(copy, 8000, rate);
    kept += copy[100];
  });
  time("lower limit", [&](std::uint64_t) {
    auto copy = clip;
    synth::recording::cut_below(copy, 80, rate);
    kept += copy[100];
  });
  for (const auto codec : {synth::recording::Codec::mp3, synth::recording::Codec::vorbis,
                           synth::recording::Codec::opus}) {
    time(synth::recording::codec_names()[static_cast<std::size_t>(codec)], [&](std::uint64_t) {
      auto copy = clip;
      synth::recording::pass_through(codec, 0.3, copy, rate);
      kept += copy[100];
    });
  }
  fmt::print(stderr, "{}\n", kept);
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  carillon::bench::run(argc > 1 ? argv[1] : "");
  return EXIT_SUCCESS;
}
