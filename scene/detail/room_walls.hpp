#pragma once

#include "scene/room_scene.hpp"

namespace carillon::scene {

/// Sides of the smallest or the largest room of a pool [m].
Vec3 room_size(const RoomScene& scene, bool largest);

/// Walls as `room` gives them, or as its reverberation time asks for.
/// @param rt60  of the room where one number or a range is given [s]
/// @throws InputError  a reverberation time that no walls give
synth::room::WallAbsorption walls_of(const RoomScene& scene, const Vec3& size, double sample_rate,
                                     double rt60);

}  // namespace carillon::scene
