#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/vectors.hpp"

namespace carillon::scene::live {

/// What is asked of objects that are played, whoever asks: text, keyboard, MIDI or OSC.
struct Request {
  enum class Kind {
    strike,   ///< an object
    support,  ///< one of an object's supports is put on, taken off or given other constants
    damp,     ///< a hand on an object
    stop      ///< the end
  };
  Kind kind = Kind::stop;
  std::optional<double> time;  ///< [s] since the first sample; none: at once
  std::string object;          ///< its name or its number, from 0; "*": all (not for support)
  /// Of strikes, in the object's coordinates; none: the object's own place, inward, and the usual
  /// ones.
  std::optional<Vec3> position;   ///< [m]
  std::optional<Vec3> direction;  ///< of the force, any length
  std::optional<double> impulse;  ///< [N s]
  std::optional<double> contact;  ///< [s]
  double strength = 1;            ///< factor of the impulse
  std::optional<int> place;       ///< one of the object's spread places, in place of a position
  int support = 0;                ///< its number, from 0
  std::optional<bool> on;         ///< of supports; none: as it is
  std::optional<double> stiffness, damping;  ///< of supports [N/m], [N s/m]; none: as they are
  double amount = 0;                         ///< of hands: added to every decay rate [1/s]
};

/// Reads a line of events:
///   TIME strike OBJECT [position X Y Z] [direction X Y Z] [impulse J] [contact T]
///   TIME support OBJECT NUMBER on|off | [stiffness K] [damping C]
///   TIME damp OBJECT AMOUNT
///   TIME stop
/// TIME in seconds, or - for at once; values are in SI units or have their own (1ms, 5cm).
/// @return none for an empty line, and for one of a comment (#)
/// @throws InputError  what is wrong with it, without the line's number
std::optional<Request> parse_request(std::string_view line);

}  // namespace carillon::scene::live
