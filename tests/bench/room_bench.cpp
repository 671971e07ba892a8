// What a room's responses and their convolution cost: the figures of docs/sound/room.md.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <vector>

#include "core/temporary_folder.hpp"
#include "synth/room/measured_responses.hpp"
#include "synth/room/room.hpp"
#include "synth/signal/convolution.hpp"

namespace carillon::synth {
namespace {

/// Processor time of one call, the least of several.
template <class Work>
double milliseconds(int times, const Work& work) {
  double minimum = 1e9;
  for (int i = 0; i < times; ++i) {
    const std::clock_t start = std::clock();
    work();
    minimum = std::min(minimum, 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return minimum;
}

void measure(double rt60) {
  room::RoomOptions options;
  room::OctaveValues times;
  times.fill(rt60);
  times[6] = std::min(rt60, 0.9);
  times[7] = 0.4;  // air alone allows no more
  options.walls = room::same_on_all_walls(room::absorption_for(options.size, times, options.air));
  room::RoomOptions images = options;
  images.with_tail = false;
  room::RoomOptions tail = options;
  tail.with_images = false;
  const room::RoomResponse response = room::room_response(options);
  signal::Convolver convolver;
  const auto early = convolver.prepare(response.images, options.count);
  const auto late = convolver.prepare(response.tail, options.count);
  const std::vector<float> dry(options.count, 0.1F);
  std::vector<float> wet = dry;
  const core::TemporaryFolder temporary;
  const std::filesystem::path& cache = temporary.path();
  room::cached_room_response(images, cache);
  fmt::print(
      "rt60 {} s: images {:.1f} ms (from the cache {:.1f}), tail {:.1f} ms; convolving {:.2f} "
      "and {:.2f} ms\n",
      rt60, milliseconds(15, [&] { room::room_response(images); }),
      milliseconds(15, [&] { room::cached_room_response(images, cache); }),
      milliseconds(15, [&] { room::room_response(tail); }),
      milliseconds(50, [&] { convolver.add(dry, early, wet); }),
      milliseconds(50, [&] { convolver.add(dry, late, wet); }));
}

/// A measured response of a second, of 48 kHz and of the clips' own rate.
void measure_responses() {
  std::vector<double> samples(48000);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double t = static_cast<double>(i) / 48000;
    samples[i] = std::sin(1e4 * static_cast<double>(i * i % 1009)) * std::exp(-14 * t);
  }
  const room::MeasuredOptions options;
  const auto response = room::from_direct_sound(samples, 48000, options);
  const std::vector<double> wide(response.begin(), response.end());
  signal::Convolver convolver;
  const auto spectrum = convolver.prepare(wide, options.count);
  const std::vector<float> dry(options.count, 0.1F);
  std::vector<float> wet = dry;
  fmt::print(
      "measured, 1 s: cut {:.1f} ms, from 48 kHz {:.1f} ms; spectrum {:.1f} ms; convolving "
      "{:.2f} ms\n",
      milliseconds(15, [&] { room::from_direct_sound(samples, 44100, options); }),
      milliseconds(15, [&] { room::from_direct_sound(samples, 48000, options); }),
      milliseconds(15, [&] { convolver.prepare(wide, options.count); }),
      milliseconds(50, [&] { convolver.add(dry, spectrum, wet); }));
}

}  // namespace
}  // namespace carillon::synth

int main() {
  for (const double rt60 : {0.5, 1.0}) carillon::synth::measure(rt60);
  carillon::synth::measure_responses();
}
