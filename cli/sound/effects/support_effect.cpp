#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "cli/sound/effects/list.hpp"
#include "cli/sound/effects/support_config.hpp"
#include "cli/sound/scene.hpp"
#include "core/error.hpp"
#include "core/random.hpp"
#include "synth/coupled_modes.hpp"
#include "synth/supports.hpp"

namespace carillon::cli {

namespace {

using solvers::Vec3;
using Place = SupportConfig::Place;

/// Measured for 60 modes; docs/sound/supports.md.
constexpr double kDiagonalSeconds = 2e-5;
constexpr double kCoupledSeconds = 2e-2;
/// Bodies whose contacts are kept ready.
constexpr std::size_t kBodies = 32;

/// A place that is pressed with one force, at a body.
struct Hold {
  const SupportConfig* config = nullptr;
  Eigen::MatrixXd unit;        ///< dashpots for 1 N s/m
  Vec3 centre = Vec3::Zero();  ///< [m]
};

/// What is known of a body before a sound: the contacts that are not drawn, and the last coupled
/// answer.
struct HeldBody {
  std::vector<Hold> holds;  ///< without dashpots where they are drawn
  std::vector<double> decay_rates;
  std::optional<synth::CoupledModes> coupled;
  bool solved = false;
};

Hold hold_of(const RingingBody& body, const SupportConfig& config,
             const std::vector<synth::Contact>& contacts) {
  return {&config, synth::unit_dashpots(*body.modes, contacts, config.kind.friction),
          synth::centre_of(body.modes->surface, contacts)};
}

class Supports {
 public:
  explicit Supports(SupportsConfig config) : config_(std::move(config)) {}

  void prepare(const RingingBody& body) {
    if (bodies_.size() >= kBodies) bodies_.clear();
    HeldBody held;
    const solvers::ModeSurface& surface = body.modes->surface;
    for (const SupportConfig& config : config_.contacts) {
      switch (config.place) {
        case Place::at:
          for (const Vec3& point : config.points) {
            const auto nearest = body.sampler->nearest(body.centre + point);
            held.holds.push_back(
                hold_of(body, config, synth::patch_contacts(surface, nearest, config.radius)));
          }
          break;
        case Place::random:
          for (int k = 0; k < config.count; ++k) {
            held.holds.push_back({&config, {}, Vec3::Zero()});
          }
          break;
        case Place::lowest:
          held.holds.push_back(hold_of(
              body, config, synth::lowest_contacts(surface, config.down, config.height)));
          break;
        case Place::along: {
          std::vector<Vec3> line;
          for (const Vec3& corner : config.points) line.push_back(body.centre + corner);
          held.holds.push_back(hold_of(
              body, config, synth::edge_contacts(surface, *body.sampler, line, config.count)));
          break;
        }
      }
    }
    bodies_.insert_or_assign(body.id, std::move(held));
  }

  void hold(Sound& sound) {
    const RingingBody& body = *sound.body;
    if (!bodies_.contains(body.id)) prepare(body);
    HeldBody& held = bodies_.at(body.id);
    const std::vector<Hold> holds = draw_places(held, sound);
    const std::vector<double> forces = draw_forces(holds, sound);
    std::vector<Eigen::MatrixXd> parts;
    Eigen::Index columns = 0;
    for (std::size_t h = 0; h < holds.size(); ++h) {
      parts.push_back(
          synth::dashpots(holds[h].unit, holds[h].config->kind.coefficient, forces[h]));
      columns += parts.back().cols();
    }
    Eigen::MatrixXd dashpots(static_cast<Eigen::Index>(body.modes->size()), columns);
    columns = 0;
    for (const Eigen::MatrixXd& part : parts) {
      dashpots.middleCols(columns, part.cols()) = part;
      columns += part.cols();
    }
    const auto diagonal = synth::with_support_damping(sound.rings.decay_rates, dashpots);
    record_holds(sound, holds, forces, diagonal);
    if (config_.full && couple(sound, held, dashpots, diagonal)) return;
    sound.rings.decay_rates = diagonal;
  }

 private:
  std::vector<Hold> draw_places(const HeldBody& held, const Sound& sound) const {
    std::vector<Hold> holds = held.holds;
    core::RandomStream random(sound.seed, sound.id, "supports.place");
    for (Hold& hold : holds) {
      if (hold.config->place != Place::random) continue;
      const auto point = sound.body->sampler->sample(random);
      hold = hold_of(
          *sound.body, *hold.config,
          synth::patch_contacts(sound.body->modes->surface, point, hold.config->radius));
    }
    return holds;
  }

  std::vector<double> draw_forces(const std::vector<Hold>& holds, const Sound& sound) const {
    const auto bearing = std::count_if(holds.begin(), holds.end(),
                                       [](const Hold& h) { return !h.config->force; });
    core::RandomStream random(sound.seed, sound.id, "supports.force");
    std::vector<double> forces;
    for (const Hold& hold : holds) {
      const auto& force = hold.config->force;
      forces.push_back(force ? random.log_uniform(force->low, force->high)
                             : synth::weight(*sound.body->modes) / static_cast<double>(bearing));
    }
    return forces;
  }

  /// Turns the modes into the coupled body's oscillators; false where the diagonal answer stays.
  bool couple(Sound& sound, HeldBody& held, const Eigen::MatrixXd& dashpots,
              const std::vector<double>& diagonal) const {
    synth::RingDown& rings = sound.rings;
    if (!held.solved || !config_.fixed() || held.decay_rates != rings.decay_rates) {
      held.coupled = synth::couple(rings.eigenvalues, rings.decay_rates, dashpots);
      held.decay_rates = rings.decay_rates;
      held.solved = true;
    }
    const bool coupled = held.coupled.has_value();
    const synth::DiagonalError error =
        coupled ? synth::diagonal_error(*held.coupled, rings.eigenvalues, diagonal)
                : synth::DiagonalError{};
    if (sound.record != nullptr) {
      sound.record->add("support_coupled", static_cast<std::int64_t>(coupled));
      sound.record->add("support_modes_compared", static_cast<std::int64_t>(error.matched));
      sound.record->add("support_decay_error", error.decay_rate);
      sound.record->add("support_pitch_error", error.cents, "cent");
    }
    if (coupled) rings = synth::coupled_ring_down(*held.coupled, rings);
    return coupled;
  }

  static void record_holds(Sound& sound, const std::vector<Hold>& holds,
                           const std::vector<double>& forces,
                           const std::vector<double>& diagonal) {
    if (sound.record == nullptr) return;
    std::vector<double> positions;
    for (const Hold& hold : holds) {
      positions.insert(positions.end(), hold.centre.begin(), hold.centre.end());
    }
    double added = 0;
    for (std::size_t i = 0; i < diagonal.size(); ++i) {
      added = std::max(added, diagonal[i] - sound.rings.decay_rates[i]);
    }
    sound.record->add("support_force", std::span<const double>(forces), {holds.size()}, "N");
    sound.record->add("support_position", std::span<const double>(positions), {holds.size(), 3},
                      "m");
    sound.record->add("support_damping", added, "1/s");
  }

  SupportsConfig config_;
  std::map<std::string, HeldBody> bodies_;
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
  effect.seconds_per_sound =
      config.full && !config.fixed() ? kCoupledSeconds : kDiagonalSeconds;
  effect.start = [config = std::move(config)](const std::filesystem::path&) {
    const auto supports = std::make_shared<Supports>(config);
    EffectParts parts;
    parts.body = [supports](RingingBody& body) { supports->prepare(body); };
    parts.rings = [supports](Sound& sound) { supports->hold(sound); };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect supports_effect = {
    .name = "supports", .description = "damping by what holds the body", .read = read};

}  // namespace carillon::cli
