#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "scene/effect.hpp"
#include "scene/support_config.hpp"
#include "synth/support/supports.hpp"

namespace carillon::scene {

/// A place that is pressed with one force, at an object.
struct Hold {
  const SupportConfig* config = nullptr;
  Eigen::MatrixXd unit;        ///< dashpots for 1 N s/m: modes, then rigid coordinates
  Eigen::VectorXd diagonal;    ///< of their damping, of the modes
  Eigen::MatrixXd linear;      ///< dashpots whatever the force, likewise; no columns: none
  Vec3 centre = Vec3::Zero();  ///< from the centre of the object's box [m]
};

/// A hold as one sound has it: pressed with a force.
struct Press {
  std::shared_ptr<const Hold> hold;
  double force = 0;         ///< [N]; 0: it is not there in this sound
  std::int64_t index = -1;  ///< in the contact's pool; -1: it has none
};

/// Where supports touch an object, as far as that is the same for all of its sounds.
struct HeldPlaces {
  std::optional<synth::modal::SurfaceSampler> sampler;  ///< only where points are sought or drawn
  std::vector<synth::surface::SurfaceTriangle> triangles;  ///< only where patches are asked for
  /// In the order of the configuration, without what is drawn.
  std::vector<std::shared_ptr<const Hold>> fixed;
  /// Of each contact that has one, in the order of the configuration; drawn for the first sound.
  /// The object's weight is no part of the forces.
  std::vector<std::vector<Press>> pools;
  /// None for an object of several pieces, of which each would move by itself.
  std::optional<synth::surface::RigidBody> rigid;
};

/// @param config  must outlive what is returned
/// @throws InputError  a place that is given is farther from the surface than the object is large
HeldPlaces find_places(const RingingObject& object, const SupportsConfig& config);

/// The springs among the supports: S of hold_modes(), modes and six rigid coordinates.
/// @throws InputError  as find_places()
Eigen::MatrixXd find_springs(const RingingObject& object, const SupportsConfig& config,
                             const synth::surface::RigidBody& rigid);

/// Keys of what is drawn for a sound.
struct SoundKey {
  std::uint64_t seed = 0, id = 0;
};

/// What may hold the object during a sound, in the order of the configuration: draws what is drawn.
std::vector<Press> press(HeldPlaces& places, const SupportsConfig& config,
                         const RingingObject& object, SoundKey key);

}  // namespace carillon::scene
