#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "scene/live/request.hpp"
#include "scene/scene.hpp"
#include "synth/live/player.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::scene::live {

/// What may hold an object while it sounds. Its dashpot c and its spring k add c u / 2 to a mode's
/// decay rate and k u to its eigenvalue, with u the diagonal of synth::support::contact_factor():
/// the first order in what the support adds (Rayleigh's quotient), modes stay uncoupled.
struct LiveSupport {
  std::string name;
  Eigen::VectorXd unit;  ///< u of each mode [1/kg]
  double damping = 0;    ///< c [N s/m]; of a bed alone 1: as often as it is there
  double stiffness = 0;  ///< k [N/m]
  bool on = true;
};

/// An object that can be played.
struct LiveObject {
  std::string name;
  std::shared_ptr<const solvers::modes::Modes> modes;
  std::vector<double> decay_rates;  ///< without supports [1/s]
  synth::modal::Readout readout;
  synth::modal::SurfacePoint place;                ///< struck where nothing else is said
  std::vector<synth::modal::SurfacePoint> places;  ///< spread over it, for keys
  std::vector<LiveSupport> supports;
};

/// How strikes are that say nothing else.
struct UsualStrike {
  double impulse = 0.02;  ///< [N s]
  double contact = 2e-4;  ///< [s]
};

/// Longest contact of a strike that is played [s].
inline constexpr double longest_live_contact = 10;

/// Objects that are played: requests in, events of a player out. Any threads but the player's own
/// may ask; a lock is theirs alone.
class Instrument {
 public:
  /// @param objects  at least one, all of as many rows
  /// @param gain     full scale per m/s or Pa
  /// @throws InputError  no objects, two of one name
  Instrument(std::vector<LiveObject> objects, const UsualStrike& usual, double sample_rate,
             double gain);

  /// @throws InputError  an unknown object or support, a point off the object, a value that cannot
  ///                     be
  void apply(const Request& request);

  synth::live::Player& player() { return player_; }
  const std::vector<LiveObject>& objects() const { return objects_; }
  const UsualStrike& usual() const { return usual_; }
  std::size_t modes() const;  ///< of all objects

 private:
  std::vector<std::size_t> named(const std::string& object) const;
  void strike(std::size_t object, const Request& request);
  void hold(std::size_t object, const std::optional<double>& time);

  synth::live::Player player_;
  std::vector<LiveObject> objects_;
  std::vector<double> hands_;                                            ///< on each object [1/s]
  std::vector<std::unique_ptr<synth::modal::SurfaceSampler>> samplers_;  ///< made when needed
  UsualStrike usual_;
  std::mutex mutex_;
};

}  // namespace carillon::scene::live
