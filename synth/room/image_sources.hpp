#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "synth/room/octave_filters.hpp"
#include "synth/room/room_acoustics.hpp"

namespace carillon::synth::room {

/// The source as seen in the walls of a shoebox room (Allen and Berkley, JASA 65, 943, 1979).
struct ImageSource {
  Eigen::Vector3d position;
  std::array<int, wall_count> hits{};  ///< reflections at each wall on the way
  int order = 0;                       ///< their sum
  double distance = 0;                 ///< to the listener [m]
};

/// Highest order that is computed; there are about 4/3 order^3 images.
inline constexpr int highest_order = 20;

/// @throws InputError  a size that is not positive, an order outside 0 to highest_order, a source
///                     or a listener outside the room or on a wall, or both at one point
void check_room(const Eigen::Vector3d& size, const Eigen::Vector3d& source,
                const Eigen::Vector3d& listener, int order);

/// All images from order 1 to `order`, nearest first, of a room that check_room lets pass.
std::vector<ImageSource> image_sources(const Eigen::Vector3d& size, const Eigen::Vector3d& source,
                                       const Eigen::Vector3d& listener, int order);

/// Pressure of an image at the listener against that of the source, by octave: walls reflect
/// sqrt(1 - absorption) of it, the distance takes r0 / r, the longer way through air
/// exp(-m (r - r0) / 2).
/// @param direct  distance r0 of source and listener [m]
/// @param m       air absorption of energy [1/m]
OctaveValues image_gains(const ImageSource& image, double direct, const WallAbsorption& walls,
                         const OctaveValues& m);

/// Response of images after the direct sound, which would be 1 at sample 0 and is left out: each
/// arrives (r - r0) / c later. Fractions of a sample by a sinc in a Hann window of 81 samples that
/// is centred on the arrival (one that arrives within 40 samples gets a shorter one, so that
/// nothing is there before the direct sound), octaves by minimum-phase filters.
/// @param count  samples; what would come later is left out
std::vector<double> image_response(std::span<const ImageSource> images, double direct,
                                   const WallAbsorption& walls, const Air& air, double sample_rate,
                                   std::size_t count, const ReflectionFilters& filters);

/// Weights of a fractional delay: of samples first, first + 1, ... around `delay`.
struct DelayKernel {
  std::size_t first = 0;
  std::vector<double> weights;  ///< their sum is 1
};
/// @param delay  [samples], 0 or more
DelayKernel fractional_delay(double delay);

}  // namespace carillon::synth::room
