#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "synth/support/supports.hpp"

namespace carillon::scene {

/// One entry of `supports.contacts`: what holds the object where, and how firmly.
struct SupportConfig {
  enum class Place { at, random, lowest, along };

  synth::support::SupportKind kind;
  Place place = Place::at;
  std::vector<Vec3> points;  ///< at, along: from the centre of the object's box [m]
  int count = 0;             ///< random: so many places; along: points of contact
  int pool =
      0;  ///< random: drawn once for an object, of which each sample takes `count`; 0: new ones
  double radius = 0;                 ///< at, random: of a patch [m]; 0: a point
  double height = 0;                 ///< lowest: of the contact above the lowest point [m]
  Vec3 down = {0, 0, -1};            ///< lowest
  std::optional<core::Range> force;  ///< [N] of each hold; none: a fraction of the object's weight
  double probability = 1;            ///< that it is there in a sample

  /// Places that are pressed with a force each.
  int holds() const;
};

struct SupportsConfig {
  bool full = false;  ///< coupling: full
  std::vector<SupportConfig> contacts;

  int holds() const;
  /// Some contact has a pool.
  bool pooled() const;
  /// Neither places nor forces are drawn: every sample of an object is held alike.
  bool fixed() const;
  /// Some contact is a spring, which changes the object's modes.
  bool gives_way() const;
};

/// @param node   the mapping under `supports`
/// @param moves  of a scene that moves: all its simulations are held alike, coupling is diagonal
/// @throws ConfigError
SupportsConfig read_supports(core::ConfigNode& node, bool moves = false);

/// What stands on its lowest side, with its weight on something of a kind.
SupportsConfig standing_on(const std::string& kind);

}  // namespace carillon::scene
