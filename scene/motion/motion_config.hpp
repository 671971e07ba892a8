#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "render/scene_frame.hpp"
#include "scene/motion/texture_config.hpp"
#include "scene/support_config.hpp"
#include "synth/material/material.hpp"
#include "synth/motion/lasting_force.hpp"
#include "synth/motion/motion.hpp"
#include "synth/touch/stylus.hpp"

namespace carillon::scene::motion {

using Ranges3 = std::array<core::Range, 3>;

/// What a contact is to a surface.
struct SurfaceConfig {
  double friction = 0.4;
  double rolling_friction = 0;  ///< [m]
  double restitution = 0.6;
};

/// One body of the cast. Every range is drawn for each simulation.
struct CastBody {
  std::size_t entry = 0;  ///< of `motion.bodies`
  std::string name;
  std::string object;  ///< name of an entry of `objects`
  /// One of them is drawn; all are among the object's. Empty where its physical groups have theirs.
  std::vector<std::string> materials;
  double size = 1;
  bool fixed = false;
  core::Range release{};  ///< held at its start until then [s]
  bool one_hull = false;  ///< collides as the hull of all its pieces
  Ranges3 at{};           ///< centre of its box at the start [m]
  Ranges3 turn{};         ///< about x, then y, then z of the world [rad]
  Ranges3 velocity{};     ///< [m/s]
  Ranges3 spin{};         ///< [rad/s]
  SurfaceConfig surface;
  double edge_radius = 0.001;   ///< of what strikes, where it is no ball [m]
  std::string rests = "table";  ///< kind of support that lasting contacts are
  /// Of what is fixed: what holds it. Its own, else the scene's, else it stands on `rests`.
  std::shared_ptr<const SupportsConfig> held_by;
  std::optional<TextureConfig> texture;
};

struct CastString {
  std::string body;
  Vec3 at = Vec3::Zero();        ///< from the centre of the body's box, as it lies unturned [m]
  Vec3 anchor = Vec3::Zero();    ///< world [m]
  double length = 0;             ///< [m]; 0: taut at the start
  std::string rests = "string";  ///< kind of support that it is to the body's modes
};

/// A flat floor at z = 0 that makes no sound.
struct GroundConfig {
  std::string material;
  double side = 10;  ///< [m]
  SurfaceConfig surface;
  std::optional<TextureConfig> texture;
};

/// `motion.camera`: frames of the scene, at even times from the start.
struct MotionCamera {
  render::SceneCamera view;
  double rate = 25;  ///< [Hz]
  bool depth = true;
  bool masks = true;
  bool movie = false;  ///< an MP4 of each simulation, with its sound

  std::size_t frames(double seconds) const {
    return static_cast<std::size_t>(seconds * rate + 1e-9) + 1;
  }
  /// Of all frames of a simulation.
  double pixels(double seconds) const {
    return static_cast<double>(view.width) * view.height * static_cast<double>(frames(seconds));
  }
};

/// `motion.stylus`: a pen that is drawn over a body's textured face.
struct StylusConfig {
  std::string body;
  std::vector<std::pair<core::Range, core::Range>> path;  ///< corners u, v on the face [m]
  core::Range speed{0.1, 0.1};                            ///< [m/s]
  synth::touch::Stylus stylus;
};

/// `motion:` of a configuration: its samples are simulations of a scene that moves.
struct MotionConfig {
  int simulations = 1;
  synth::motion::MotionOptions options;  ///< all but the seconds, which are those of the audio
  double state_rate = 100;               ///< of the column `poses` [Hz]
  int kept_strikes = 256;                ///< rows of the strikes' columns, the strongest ones
  bool hertz_pulses = false;
  synth::motion::LastingForceOptions contacts;  ///< all but rate and seed
  std::optional<GroundConfig> ground;
  std::vector<CastBody> bodies;  ///< repeats expanded
  std::vector<CastString> strings;
  std::optional<MotionCamera> camera;
  std::optional<StylusConfig> stylus;
};

/// What a motion needs to know of an entry of `objects`.
struct CastObject {
  std::string name;
  std::vector<std::string> materials;
  std::vector<double> sizes;
};

/// Reads `motion`.
/// @param supports  the scene's, which hold what is fixed and has none of its own; null: none
/// @throws ConfigError
MotionConfig read_motion(core::ConfigNode node, const std::string& file_name,
                         const std::vector<CastObject>& objects,
                         const std::vector<synth::material::Material>& own_materials,
                         const std::shared_ptr<const SupportsConfig>& supports);

}  // namespace carillon::scene::motion
