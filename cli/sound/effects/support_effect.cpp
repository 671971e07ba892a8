#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cli/sound/effects/list.hpp"
#include "cli/sound/effects/support_config.hpp"
#include "cli/sound/scene.hpp"
#include "core/error.hpp"
#include "core/random.hpp"
#include "synth/coupled_modes.hpp"
#include "synth/diagonal_error.hpp"
#include "synth/supports.hpp"

namespace carillon::cli {

namespace {

using solvers::Vec3;
using Place = SupportConfig::Place;

/// A bound.
constexpr double kDiagonalSeconds = 2e-5;
/// Measured (docs/sound/supports.md): the coupled problem of n modes takes n^3 times this, the
/// estimate of the diagonal answer's error n^2 times this.
constexpr double kCoupledSeconds = 2e-8;
constexpr double kEstimateSeconds = 3e-8;
/// Bodies whose contacts are kept ready.
constexpr std::size_t kBodies = 32;

/// A place that is pressed with one force, at a body.
struct Hold {
  const SupportConfig* config = nullptr;
  Eigen::MatrixXd unit;        ///< dashpots for 1 N s/m: modes, then rigid coordinates
  Eigen::VectorXd diagonal;    ///< of their damping, of the modes
  Vec3 centre = Vec3::Zero();  ///< from the centre of the body's box [m]
};

/// What is known of a body before a sound.
struct HeldBody {
  std::optional<synth::SurfaceSampler> sampler;   ///< only where points are sought or drawn
  std::vector<synth::SurfaceTriangle> triangles;  ///< only where patches are asked for
  std::vector<Hold> fixed;  ///< in the order of the configuration, without what is drawn
  /// None for a body of several pieces, of which each would move by itself.
  std::optional<synth::RigidBody> rigid;
  // The last answer, and for which decay rates it is.
  std::vector<double> decay_rates;
  std::optional<synth::CoupledModes> coupled;
  synth::DiagonalError error;
  bool solved = false;
  bool warned = false;
};

Hold hold_of(const RingingBody& body, const HeldBody& held, const SupportConfig& config,
             const std::vector<synth::Contact>& contacts) {
  Hold hold;
  hold.config = &config;
  hold.unit = synth::unit_dashpots(*body.modes, contacts, config.kind.friction,
                                   held.rigid ? &*held.rigid : nullptr);
  hold.diagonal =
      hold.unit.topRows(static_cast<Eigen::Index>(body.modes->size())).rowwise().squaredNorm();
  hold.centre = synth::centre_of(body.modes->surface, contacts) - body.centre;
  return hold;
}

/// The nearest point of the surface to one that was given from the centre of the body's box.
/// @throws InputError  it is farther from the surface than the body is large
synth::SurfacePoint nearest(const RingingBody& body, const synth::SurfaceSampler& sampler,
                            const Vec3& given, const char* key) {
  const solvers::ModeSurface& surface = body.modes->surface;
  const synth::SurfacePoint point = sampler.nearest(body.centre + given);
  const double away = (synth::frame_at(surface, point).position - body.centre - given).norm();
  Eigen::AlignedBox3d box;
  for (const Vec3& node : surface.nodes) box.extend(node);
  if (!(away <= box.diagonal().norm())) {
    throw core::InputError(
        fmt::format("supports: {}: [{}, {}, {}] m is {:.3g} m away from the surface of {}, which "
                    "is {:.3g} m from corner to corner",
                    key, given.x(), given.y(), given.z(), away, body.id, box.diagonal().norm()),
        "places are from the centre of the body's box at its actual size; a forgotten cm or mm?");
  }
  return point;
}

/// A hold as one sound has it: pressed with a force.
struct Press {
  const Hold* hold = nullptr;
  double force = 0;  ///< [N]
};

class Supports {
 public:
  explicit Supports(SupportsConfig config) : config_(std::move(config)) {}

  void prepare(const RingingBody& body) {
    if (bodies_.size() >= kBodies) bodies_.clear();
    HeldBody held;
    if (body.modes->certificate.components <= 1) held.rigid = synth::rigid_body(*body.modes);
    const solvers::ModeSurface& surface = body.modes->surface;
    const auto& contacts = config_.contacts;
    if (std::any_of(contacts.begin(), contacts.end(),
                    [](const auto& c) { return c.place != Place::lowest; })) {
      held.sampler.emplace(surface);
    }
    if (std::any_of(contacts.begin(), contacts.end(), [](const auto& c) { return c.radius > 0; })) {
      held.triangles = synth::outer_pieces(surface);
    }
    for (const SupportConfig& config : contacts) {
      switch (config.place) {
        case Place::at:
          for (const Vec3& point : config.points) {
            const auto place = nearest(body, *held.sampler, point, "at");
            held.fixed.push_back(
                hold_of(body, held, config,
                        synth::patch_contacts(surface, held.triangles, place, config.radius)));
          }
          break;
        case Place::random:
          break;
        case Place::lowest:
          held.fixed.push_back(hold_of(
              body, held, config, synth::lowest_contacts(surface, config.down, config.height)));
          break;
        case Place::along: {
          std::vector<Vec3> line;
          for (const Vec3& corner : config.points) {
            nearest(body, *held.sampler, corner, "along");
            line.push_back(body.centre + corner);
          }
          held.fixed.push_back(
              hold_of(body, held, config,
                      synth::edge_contacts(surface, *held.sampler, line, config.count)));
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
    const std::vector<Hold> drawn = draw_places(held, sound);
    const std::vector<Press> presses = press(held, drawn, sound);
    std::vector<double> diagonal = sound.rings.decay_rates;
    for (const Press& p : presses) {
      synth::add_support_damping(diagonal, p.hold->diagonal, p.hold->config->kind.coefficient,
                                 p.force);
    }
    record_presses(sound, presses, diagonal);
    if (config_.full && couple(sound, held, presses, diagonal)) return;
    if (!config_.full) estimate(sound, held, presses, diagonal);
    sound.rings.decay_rates = std::move(diagonal);
  }

 private:
  std::vector<Hold> draw_places(const HeldBody& held, const Sound& sound) const {
    std::vector<Hold> holds;
    core::RandomStream random(sound.seed, sound.id, "supports.place");
    for (const SupportConfig& config : config_.contacts) {
      if (config.place != Place::random) continue;
      for (int k = 0; k < config.count; ++k) {
        const auto point = held.sampler->sample(random);
        holds.push_back(hold_of(*sound.body, held, config,
                                synth::patch_contacts(sound.body->modes->surface, held.triangles,
                                                      point, config.radius)));
      }
    }
    return holds;
  }

  /// All holds in the order of the configuration, with their forces.
  std::vector<Press> press(const HeldBody& held, const std::vector<Hold>& drawn,
                           const Sound& sound) const {
    int bearing = 0;
    for (const SupportConfig& config : config_.contacts) {
      if (!config.force) bearing += config.holds();
    }
    core::RandomStream random(sound.seed, sound.id, "supports.force");
    std::vector<Press> presses;
    auto fixed = held.fixed.begin();
    auto next_drawn = drawn.begin();
    for (const SupportConfig& config : config_.contacts) {
      for (int k = 0; k < config.holds(); ++k) {
        const Hold& hold = config.place == Place::random ? *next_drawn++ : *fixed++;
        const double force = config.force
                                 ? random.log_uniform(config.force->low, config.force->high)
                                 : synth::weight(*sound.body->modes) / bearing;
        presses.push_back({&hold, force});
      }
    }
    return presses;
  }

  /// Whether the last answer does not serve this sound; it is then the one to be found.
  bool renew(HeldBody& held, const Sound& sound) const {
    if (held.solved && config_.fixed() && held.decay_rates == sound.rings.decay_rates) return false;
    held.decay_rates = sound.rings.decay_rates;
    held.solved = true;
    return true;
  }

  /// Turns the modes into the coupled body's oscillators; false where the diagonal answer stays.
  bool couple(Sound& sound, HeldBody& held, const std::vector<Press>& presses,
              const std::vector<double>& diagonal) const {
    synth::RingDown& rings = sound.rings;
    if (renew(held, sound)) {
      held.coupled.reset();
      if (held.rigid) {
        held.coupled = synth::couple(rings.eigenvalues, rings.decay_rates, dashpots_of(presses));
      }
      held.error = held.coupled ? synth::diagonal_error(*held.coupled, rings.eigenvalues, diagonal)
                                : synth::DiagonalError{.modes = static_cast<int>(diagonal.size())};
    }
    const bool coupled = held.coupled.has_value();
    if (!coupled && !held.warned) {
      held.warned = true;
      spdlog::warn("{}: supports do not couple its modes: {}; the diagonal damping is taken",
                   sound.body->id,
                   held.rigid ? "their eigenvectors are dependent" : "it has several pieces");
    }
    if (sound.record != nullptr) {
      sound.record->add("support_coupled", static_cast<std::int64_t>(coupled));
      sound.record->add("support_modes", static_cast<std::int64_t>(held.error.modes));
      sound.record->add("support_modes_compared", static_cast<std::int64_t>(held.error.matched));
      sound.record->add("support_decay_error", held.error.decay_rate);
      sound.record->add("support_pitch_error", held.error.cents, "cent");
    }
    if (coupled) rings = synth::coupled_ring_down(*held.coupled, rings);
    return coupled;
  }

  /// Records about how far the diagonal answer is off.
  void estimate(Sound& sound, HeldBody& held, const std::vector<Press>& presses,
                const std::vector<double>& diagonal) const {
    if (sound.record == nullptr) return;
    if (renew(held, sound)) {
      held.error =
          synth::estimate_diagonal_error(sound.rings.eigenvalues, diagonal, dashpots_of(presses));
    }
    sound.record->add("support_decay_error_estimate", held.error.decay_rate);
    sound.record->add("support_pitch_error_estimate", held.error.cents, "cent");
  }

  static Eigen::MatrixXd dashpots_of(const std::vector<Press>& presses) {
    Eigen::Index columns = 0;
    for (const Press& p : presses) columns += p.hold->unit.cols();
    Eigen::MatrixXd all(presses.front().hold->unit.rows(), columns);
    columns = 0;
    for (const Press& p : presses) {
      all.middleCols(columns, p.hold->unit.cols()) =
          synth::dashpots(p.hold->unit, p.hold->config->kind.coefficient, p.force);
      columns += p.hold->unit.cols();
    }
    return all;
  }

  static void record_presses(Sound& sound, const std::vector<Press>& presses,
                             const std::vector<double>& diagonal) {
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
    sound.record->add("support_force", std::span<const double>(forces), {forces.size()}, "N");
    sound.record->add("support_position", std::span<const double>(positions), {forces.size(), 3},
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
  effect.seconds_per_sound = kDiagonalSeconds;
  if (!config.fixed()) {
    effect.seconds_by_modes = [full = config.full](int modes) {
      // Beyond the most that can be coupled there is an error rather than a cost.
      const double n = std::min(modes, static_cast<int>(synth::kMostCoupledModes));
      return full ? kCoupledSeconds * n * n * n : kEstimateSeconds * modes * modes;
    };
  }
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

const Effect supports_effect = {.name = "supports",
                                .description = "damping by what holds the body",
                                .key = "supports",
                                .stage = "rings",
                                .read = read};

}  // namespace carillon::cli
