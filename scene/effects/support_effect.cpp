#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scene/effects/detail/list.hpp"
#include "scene/effects/detail/support_places.hpp"
#include "scene/scene.hpp"
#include "synth/support/coupled_modes.hpp"
#include "synth/support/diagonal_error.hpp"
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

  void prepare(const RingingObject& object) {
    if (objects_.size() >= max_ready_objects) objects_.clear();
    HeldObject held;
    held.places = find_places(object, config_);
    objects_.insert_or_assign(object.id, std::move(held));
  }

  void hold(Sound& sound) {
    const RingingObject& object = *sound.object;
    if (!objects_.contains(object.id)) prepare(object);
    HeldObject& held = objects_.at(object.id);
    const std::vector<Press> presses = press(held.places, config_, sound);
    std::vector<double> diagonal = sound.rings.decay_rates;
    for (const Press& p : presses) {
      synth::support::add_support_damping(diagonal, p.hold->diagonal,
                                          p.hold->config->kind.coefficient, p.force);
    }
    record_presses(sound, presses, diagonal);
    if (config_.full && couple(sound, held, presses, diagonal)) return;
    if (!config_.full) estimate(sound, held, presses, diagonal);
    sound.rings.decay_rates = std::move(diagonal);
  }

 private:
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
      if (held.places.rigid) {
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
          held.places.rigid ? "their eigenvectors are dependent" : "it has several pieces");
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

  static Eigen::MatrixXd dashpots_of(const std::vector<Press>& presses) {
    Eigen::Index columns = 0;
    for (const Press& p : presses) columns += p.hold->unit.cols();
    Eigen::MatrixXd all(presses.front().hold->unit.rows(), columns);
    columns = 0;
    for (const Press& p : presses) {
      all.middleCols(columns, p.hold->unit.cols()) =
          synth::support::dashpots(p.hold->unit, p.hold->config->kind.coefficient, p.force);
      columns += p.hold->unit.cols();
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

SceneEffect read(core::ConfigNode& root, const Scene&) {
  SceneEffect effect;
  if (!root.has("supports")) {
    effect.reason_off = "free flight: no supports:";
    return effect;
  }
  effect.asked_by = "supports: (" + root.where("supports") + ")";
  core::ConfigNode node = root.child("supports");
  SupportsConfig config = read_supports(node);
  effect.seconds_per_sound = diagonal_seconds;
  if (!config.fixed()) {
    effect.seconds_by_modes = [full = config.full](int modes) {
      // Beyond the most that can be coupled there is an error rather than a cost.
      const double n = std::min(modes, static_cast<int>(synth::support::max_coupled_modes));
      return full ? coupled_seconds * n * n * n : estimate_seconds * modes * modes;
    };
  }
  effect.start = [config = std::move(config)](const std::filesystem::path&) {
    const auto supports = std::make_shared<Supports>(config);
    EffectParts parts;
    parts.object = [supports](RingingObject& object) { supports->prepare(object); };
    parts.rings = [supports](Sound& sound) { supports->hold(sound); };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect supports_effect = {.name = "supports",
                                .description = "damping by what holds the object",
                                .key = "supports",
                                .stage = "rings",
                                .read = read};

}  // namespace carillon::scene
