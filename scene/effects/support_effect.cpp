#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/effects/detail/support_places.hpp"
#include "scene/scene.hpp"
#include "synth/support/coupled_modes.hpp"
#include "synth/support/diagonal_error.hpp"
#include "synth/support/held_modes.hpp"
#include "synth/support/supports.hpp"

namespace carillon::scene {

namespace {

/// A bound.
constexpr double diagonal_seconds = 2e-5;
/// Measured (docs/sound/supports.md): the coupled problem of n modes takes n^3 times this, the
/// estimate of the diagonal answer's error n^2 times this.
constexpr double coupled_seconds = 2e-8;
constexpr double estimate_seconds = 3e-8;
/// Objects whose contacts are kept ready.
constexpr std::size_t max_ready_objects = 32;

/// What is known of an object before a sound.
struct HeldObject {
  HeldPlaces places;
  // The last answer, and for which decay rates it is.
  std::vector<double> decay_rates;
  std::optional<synth::support::CoupledModes> coupled;
  synth::support::DiagonalError error;
  bool solved = false;
  bool warned = false;
};

class Supports {
 public:
  explicit Supports(SupportsConfig config) : config_(std::move(config)) {}

  void prepare(RingingObject& object) {
    const SupportsConfig* config = object.moves ? object.held_by : &config_;
    if (config == nullptr) return;
    if (config->gives_way()) put_on_springs(object, *config);
    if (object.moves) {
      // Held alike all along: its decay rates tell all that there is.
      HeldPlaces places = find_places(object, *config);
      object.decay_rates = damped(object.decay_rates, press(places, *config, object, {}));
      return;
    }
    find(object);
  }

  void hold(Sound& sound) {
    const RingingObject& object = *sound.object;
    if (!objects_.contains(object.id)) find(object);
    HeldObject& held = objects_.at(object.id);
    const std::vector<Press> presses = press(held.places, config_, object, {sound.seed, sound.id});
    std::vector<double> diagonal = damped(sound.rings.decay_rates, presses);
    record_presses(sound, presses, diagonal);
    if (config_.full && couple(sound, held, presses, diagonal)) return;
    if (!config_.full) estimate(sound, held, presses, diagonal);
    sound.rings.decay_rates = std::move(diagonal);
  }

 private:
  void find(const RingingObject& object) {
    if (objects_.size() >= max_ready_objects) objects_.clear();
    HeldObject held;
    held.places = find_places(object, config_);
    objects_.insert_or_assign(object.id, std::move(held));
  }

  /// Its modes become those that it has on springs.
  static void put_on_springs(RingingObject& object, const SupportsConfig& config) {
    if (object.modes->certificate.components > 1) {
      throw core::InputError(
          fmt::format("supports: {} has {} pieces, of which springs would hold each by itself",
                      object.id, object.modes->certificate.components),
          "leave out stiffness, or join its pieces");
    }
    const synth::surface::RigidBody rigid = synth::surface::rigid_body(*object.modes);
    synth::support::HeldModes held = synth::support::hold_modes(
        *object.modes, object.decay_rates, rigid, find_springs(object, config, rigid));
    object.held = std::make_shared<const solvers::modes::Modes>(std::move(held.modes));
    object.modes = object.held.get();
    object.decay_rates = std::move(held.decay_rates);
  }

  /// The diagonal answer.
  static std::vector<double> damped(std::vector<double> decay_rates,
                                    const std::vector<Press>& presses) {
    const auto modes = static_cast<Eigen::Index>(decay_rates.size());
    for (const Press& p : presses) {
      synth::support::add_support_damping(decay_rates, p.hold->diagonal,
                                          p.hold->config->kind.coefficient, p.force);
      if (!(p.force > 0) || p.hold->linear.cols() == 0) continue;
      synth::support::add_support_damping(
          decay_rates, p.hold->linear.topRows(modes).rowwise().squaredNorm(), 1, 1);
    }
    return decay_rates;
  }

  /// Whether the last answer does not serve this sound; it is then the one to be found.
  bool renew(HeldObject& held, const Sound& sound) const {
    if (held.solved && config_.fixed() && held.decay_rates == sound.rings.decay_rates) return false;
    held.decay_rates = sound.rings.decay_rates;
    held.solved = true;
    return true;
  }

  /// Turns the modes into the coupled object's oscillators; false where the diagonal answer stays.
  bool couple(Sound& sound, HeldObject& held, const std::vector<Press>& presses,
              const std::vector<double>& diagonal) const {
    synth::modal::RingDown& rings = sound.rings;
    if (renew(held, sound)) {
      held.coupled.reset();
      if (can_couple(held, sound)) {
        held.coupled =
            synth::support::couple(rings.eigenvalues, rings.decay_rates, dashpots_of(presses));
      }
      held.error = held.coupled
                       ? synth::support::diagonal_error(*held.coupled, rings.eigenvalues, diagonal)
                       : synth::support::DiagonalError{.modes = static_cast<int>(diagonal.size())};
    }
    const bool coupled = held.coupled.has_value();
    if (!coupled && !held.warned) {
      held.warned = true;
      spdlog::warn(
          "{}: supports do not couple its modes: {}; the diagonal damping is taken",
          sound.object->id,
          can_couple(held, sound) ? "their eigenvectors are dependent" : "it has several pieces");
    }
    if (sound.record != nullptr) {
      sound.record->add("support_coupled", static_cast<std::int64_t>(coupled));
      sound.record->add("support_modes", static_cast<std::int64_t>(held.error.modes));
      sound.record->add("support_modes_compared", static_cast<std::int64_t>(held.error.matched));
      sound.record->add("support_decay_error", held.error.decay_rate);
      sound.record->add("support_pitch_error", held.error.cents);
    }
    if (coupled) rings = synth::support::coupled_ring_down(*held.coupled, rings);
    return coupled;
  }

  /// Records about how far the diagonal answer is off.
  void estimate(Sound& sound, HeldObject& held, const std::vector<Press>& presses,
                const std::vector<double>& diagonal) const {
    if (sound.record == nullptr) return;
    if (renew(held, sound)) {
      held.error = synth::support::estimate_diagonal_error(sound.rings.eigenvalues, diagonal,
                                                           dashpots_of(presses));
    }
    sound.record->add("support_decay_error_estimate", held.error.decay_rate);
    sound.record->add("support_pitch_error_estimate", held.error.cents);
  }

  /// What moves as a whole is known: a body of one piece, or held by springs.
  static bool can_couple(const HeldObject& held, const Sound& sound) {
    return held.places.rigid.has_value() || sound.object->held != nullptr;
  }

  static Eigen::MatrixXd dashpots_of(const std::vector<Press>& presses) {
    std::vector<Eigen::MatrixXd> factors;
    Eigen::Index columns = 0;
    for (const Press& p : presses) {
      factors.push_back(
          synth::support::dashpots(p.hold->unit, p.hold->config->kind.coefficient, p.force));
      if (p.force > 0 && p.hold->linear.cols() > 0) factors.push_back(p.hold->linear);
    }
    for (const Eigen::MatrixXd& factor : factors) columns += factor.cols();
    Eigen::MatrixXd all(factors.front().rows(), columns);
    columns = 0;
    for (const Eigen::MatrixXd& factor : factors) {
      all.middleCols(columns, factor.cols()) = factor;
      columns += factor.cols();
    }
    return all;
  }

  void record_presses(Sound& sound, const std::vector<Press>& presses,
                      const std::vector<double>& diagonal) const {
    if (sound.record == nullptr) return;
    std::vector<double> forces, positions;
    for (const Press& p : presses) {
      forces.push_back(p.force);
      positions.insert(positions.end(), p.hold->centre.begin(), p.hold->centre.end());
    }
    double added = 0;
    for (std::size_t i = 0; i < diagonal.size(); ++i) {
      added = std::max(added, diagonal[i] - sound.rings.decay_rates[i]);
    }
    sound.record->add("support_force", std::span<const double>(forces), {forces.size()});
    sound.record->add("support_position", std::span<const double>(positions), {forces.size(), 3});
    sound.record->add("support_damping", added);
    if (!config_.pooled()) return;
    std::vector<std::int64_t> indices;
    for (const Press& p : presses) indices.push_back(p.index);
    sound.record->add("support_index", std::span<const std::int64_t>(indices),
                      core::Extent{indices.size()});
  }

  SupportsConfig config_;
  std::map<std::string, HeldObject> objects_;
};

/// Where a scene that moves has something fixed; "": nowhere.
std::string first_fixed(core::ConfigNode& root) {
  if (!root.has("motion")) return "";
  core::ConfigNode motion = root.child("motion");
  if (!motion.has("bodies")) return "";
  for (core::ConfigNode& body : motion.children("bodies")) {
    if (body.flag("fixed", false)) return body.where("fixed");
  }
  return "";
}

SceneEffect read(core::ConfigNode& root, const Scene&) {
  SceneEffect effect;
  const bool moves = root.has("motion");
  const std::string fixed = first_fixed(root);
  if (moves && fixed.empty() && root.has("supports")) {
    root.fail("supports", "hold what is fixed, and no body of the motion is",
              "write fixed: true at a body, or leave supports out");
  }
  if (moves ? fixed.empty() : !root.has("supports")) {
    effect.reason_off = moves ? "nothing is fixed: what is free is held by what it touches"
                              : "free flight: no supports:";
    return effect;
  }
  effect.asked_by =
      moves ? "a body is fixed: (" + fixed + ")" : "supports: (" + root.where("supports") + ")";
  SupportsConfig config;
  if (!moves) {  // what holds a body that is fixed is read with it
    core::ConfigNode node = root.child("supports");
    config = read_supports(node);
  }
  effect.seconds_per_sound = moves ? 0 : diagonal_seconds;
  if (!moves && !config.fixed()) {
    effect.seconds_by_modes = [full = config.full](int modes) {
      // Beyond the most that can be coupled there is an error rather than a cost.
      const double n = std::min(modes, static_cast<int>(synth::support::max_coupled_modes));
      return full ? coupled_seconds * n * n * n : estimate_seconds * modes * modes;
    };
  }
  effect.start = [config = std::move(config), moves](const std::filesystem::path&) {
    const auto supports = std::make_shared<Supports>(config);
    EffectParts parts;
    parts.object = [supports](RingingObject& object) { supports->prepare(object); };
    if (!moves) parts.rings = [supports](Sound& sound) { supports->hold(sound); };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect supports_effect = {.name = "supports",
                                .description = "springs and dampers of what holds the object",
                                .key = "supports",
                                .stage = "object",
                                .read = read};

}  // namespace carillon::scene
