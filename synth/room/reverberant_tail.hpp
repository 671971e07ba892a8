#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "synth/room/image_sources.hpp"
#include "synth/room/room_acoustics.hpp"

namespace carillon::synth::room {

/// The late part of a room's response as noise that decays in each octave with its reverberation
/// time, and how it joins the images.
///
/// Energy: on average, images of all orders arrive at a rate of 4 pi c^3 t^2 / V, each with (r0 / c
/// t)^2 of the direct sound's energy, and what walls and air have left of it decays by 60 dB in T:
///   P(t) = 4 pi c r0^2 / V exp(-6 ln 10 t / T)                                          [1/s]
/// with t from emission on (diffuse field; Kuttruff, Room Acoustics, 6th ed., chapters 4 and 5).
/// The tail begins when the first image beyond the chosen order would arrive and from there on
/// fills, over 5 ms at a time, what images leave of `level` P(t).
struct TailPlan {
  double start = 0;      ///< after the direct sound [s]
  double direct = 0;     ///< distance r0 of source and listener [m]
  OctaveValues rt60{};   ///< [s]
  OctaveValues power{};  ///< P at the start, level included [1/s]
  OctaveValues level{};  ///< energy of the images in the 10 ms before the start over that of P;
                         ///< 0.25 to 4; 1 with fewer than six images in them
  double join_db = 0;    ///< what the limits of `level` leave of the images' step against the
                         ///< tail, of the octave where it is largest; 0 within the limits [dB]
  double step = 0.005;   ///< [s]
  std::vector<OctaveValues>
      fill;  ///< tail's fraction of each step from the start on, 0 to 1; then 1

  /// Energy of the tail in its loudest octave against the direct sound's [dB].
  double energy_db() const;
};

/// A tail that has less than this against the direct sound is not computed [dB].
inline constexpr double inaudible_tail = -60;

/// @param images   of orders 1 to `order`, nearest first
/// @param beyond   distance of the nearest image of a higher order [m]
/// @param octaves  bands that exist at the sample rate; the others stay silent
TailPlan plan_tail(const Eigen::Vector3d& size, std::span<const ImageSource> images, double beyond,
                   double direct, const WallAbsorption& walls, const Air& air, std::size_t octaves);

/// The tail from the direct sound on (silent before its start), until every octave has decayed by
/// 90 dB or `count` samples are full. Gaussian noise in octaves with narrow crossings (1/24 octave,
/// partition of energy), its power evened out over a few periods of each octave's bandwidth, so
/// that one tail has the reverberation time that is prescribed and not only the mean of many.
/// @param seed, room  tails of equal keys are equal
std::vector<double> reverberant_tail(const TailPlan& plan, double sample_rate, std::size_t count,
                                     std::uint64_t seed, std::uint64_t room);

}  // namespace carillon::synth::room
