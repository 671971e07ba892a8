#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "scene/live/request.hpp"

namespace carillon::scene::live {

/// The note that strikes the first object or place (C2, the lowest of most keyboards).
inline constexpr int first_note = 36;

/// What a MIDI message asks for, on any channel. Note first_note + i strikes object i or, of a
/// single object, place i; velocity v gives (v / 100)^2 of the usual impulse. Controller 64, the
/// sustain pedal, takes the hand off all objects when it goes down and lays it on when it goes up;
/// controller 1 lays value / 127 of it on.
/// @param objects  how many there are
/// @param hand     [1/s]
/// @return none where it asks for nothing: other messages, notes beyond the objects, ends of notes
std::optional<Request> midi_request(std::span<const std::uint8_t> message, std::size_t objects,
                                    double hand);

}  // namespace carillon::scene::live
