#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/random.hpp"
#include "scene/scene.hpp"

namespace carillon::scene {

/// A strike where the command line says nothing else.
inline constexpr const char* default_impulse = "0.02 N s";
inline constexpr const char* default_contact_time = "0.2 ms";

/// How far off an object a point may be that is meant to be struck, over its longest side.
inline constexpr double usual_tolerance = 0.1;

/// What of a strike is given rather than drawn, in the object's coordinates.
struct KnownStrike {
  std::optional<Vec3> position;        ///< [m]; nearest_point() is struck
  std::optional<Vec3> direction;       ///< of the force, of length 1
  std::optional<double> impulse;       ///< [N s]
  std::optional<double> contact_time;  ///< [s]
  /// Over time, for an impulse of 1 N s; in place of both.
  std::optional<synth::modal::ContactForce> force = {};
  double tolerance = usual_tolerance;  ///< of the position, over the longest side
};

/// Whose random values a strike has: equal numbers under one seed draw equal values.
struct StrikeDraw {
  std::uint64_t seed = 0;
  std::uint64_t place = 0;  ///< of point and direction
  std::uint64_t force = 0;  ///< of impulse and contact time
};

/// The stream that the point and the direction of a strike are drawn from.
core::RandomStream strike_places(std::uint64_t seed, std::uint64_t place = 0);

/// The point of an object that is struck where a place is named: the surface's nearest.
/// @param position  [m]
/// @param tolerance  how far it may be off the surface, over the object's longest side
/// @throws InputError  farther off; names the nearest point and the distance
synth::modal::SurfacePoint nearest_point(const synth::modal::SurfaceSampler& sampler,
                                         const solvers::modes::ModeSurface& surface,
                                         const Vec3& position, double tolerance = usual_tolerance);

/// Draws a strike on a sound's object as a scene says: point by area, direction, impulse and
/// contact time.
/// @param surface  of the object, at any size; `sampler` is one of it
/// @throws InputError  a given point is off the object
void draw_strike(const StrikeConfig& strikes, const solvers::modes::ModeSurface& surface,
                 const synth::modal::SurfaceSampler& sampler, const StrikeDraw& draw,
                 const KnownStrike& known, Sound& sound);

/// Samples that are rendered before a clip begins, for the tails of earlier strikes.
std::size_t samples_before(const Repeats& repeats, double sample_rate);

/// Draws when a sound's strikes are: the one that begins the clip, earlier and later ones. Records
/// `strike_times`, where a scene repeats strikes.
void draw_repeats(const Repeats& repeats, double sample_rate, Sound& sound);

/// Points far from each other: the first is drawn by area, each next one is the farthest from all
/// before it (Gonzalez 1985) of 64 drawn for each point that is wanted.
std::vector<synth::modal::SurfacePoint> spread_points(const synth::modal::SurfaceSampler& sampler,
                                                      const solvers::modes::ModeSurface& surface,
                                                      std::size_t count,
                                                      core::RandomStream& places);

}  // namespace carillon::scene
