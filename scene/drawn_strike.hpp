#pragma once

#include <cstdint>
#include <optional>

#include "core/random.hpp"
#include "scene/scene.hpp"

namespace carillon::scene {

/// What of a strike is given rather than drawn, in the body's coordinates.
struct StrikePlace {
  std::optional<Vec3> at;         ///< [m]; the surface's nearest point is struck
  std::optional<Vec3> direction;  ///< of the force; not of length zero
};

/// The stream that the point and the direction of a strike are drawn from.
/// @param item  a number of its own for every strike
core::RandomStream strike_places(std::uint64_t seed, std::uint64_t item = 0);

/// Draws a strike on a sound's body as a scene says: point by area, direction, impulse and contact
/// time.
/// @param item  as strike_places()
void draw_strike(const Scene& scene, std::uint64_t seed, std::uint64_t item,
                 const StrikePlace& place, Sound& sound);

}  // namespace carillon::scene
