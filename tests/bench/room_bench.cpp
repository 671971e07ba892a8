// What a room's responses and their convolution cost: the figures of docs/sound/room.md.
#include <fmt/core.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <vector>

#include "core/temporary_folder.hpp"
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

}  // namespace
}  // namespace carillon::synth

int main() {
  for (const double rt60 : {0.5, 1.0}) carillon::synth::measure(rt60);
}
