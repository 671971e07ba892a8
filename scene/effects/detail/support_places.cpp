#include "scene/effects/detail/support_places.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::scene {

namespace {

using Place = SupportConfig::Place;

std::shared_ptr<const Hold> hold_of(const RingingObject& object, const HeldPlaces& held,
                                    const SupportConfig& config,
                                    const std::vector<synth::support::Contact>& contacts) {
  const synth::surface::RigidBody* rigid = held.rigid ? &*held.rigid : nullptr;
  Hold hold;
  hold.config = &config;
  hold.unit = synth::support::contact_factor(*object.modes, contacts, config.kind.friction, rigid);
  hold.diagonal =
      hold.unit.topRows(static_cast<Eigen::Index>(object.modes->size())).rowwise().squaredNorm();
  if (const double dashpot = config.kind.dashpot(synth::support::area_of(contacts)); dashpot > 0) {
    hold.linear = std::sqrt(dashpot) *
                  synth::support::contact_factor(*object.modes, contacts, config.kind.shear, rigid);
  }
  hold.centre = synth::support::centre_of(object.modes->surface, contacts) - object.centre;
  return std::make_shared<const Hold>(std::move(hold));
}

/// The nearest point of the surface to one that was given from the centre of the object's box.
/// @throws InputError  it is farther from the surface than the object is large
synth::modal::SurfacePoint nearest(const RingingObject& object,
                                   const synth::modal::SurfaceSampler& sampler, const Vec3& given,
                                   const char* key) {
  const solvers::modes::ModeSurface& surface = object.modes->surface;
  const synth::modal::SurfacePoint point = sampler.nearest(object.centre + given);
  const double away =
      (synth::modal::frame_at(surface, point).position - object.centre - given).norm();
  Eigen::AlignedBox3d box;
  for (const Vec3& node : surface.nodes) box.extend(node);
  if (!(away <= box.diagonal().norm())) {
    throw core::InputError(
        fmt::format("supports: {}: [{}, {}, {}] m is {:.3g} m away from the surface of {}, which "
                    "is {:.3g} m from corner to corner",
                    key, given.x(), given.y(), given.z(), away, object.id, box.diagonal().norm()),
        "places are from the centre of the object's box at its actual size; a forgotten cm or mm?");
  }
  return point;
}

std::shared_ptr<const Hold> draw_place(const HeldPlaces& held, const RingingObject& object,
                                       const SupportConfig& config, core::RandomStream& random) {
  const auto point = held.sampler->sample(random);
  return hold_of(
      object, held, config,
      synth::support::patch_contacts(object.modes->surface, held.triangles, point, config.radius));
}

/// An object's pools are the same in all of its materials and sizes.
void draw_pools(HeldPlaces& held, const SupportsConfig& supports, const RingingObject& object,
                std::uint64_t seed) {
  const std::uint64_t shape = core::stable_hash(object.shape);
  core::RandomStream places(seed, shape, "supports.pool.place");
  core::RandomStream forces(seed, shape, "supports.pool.force");
  for (const SupportConfig& config : supports.contacts) {
    if (config.pool == 0) continue;
    std::vector<Press> pool;
    for (int k = 0; k < config.pool; ++k) {
      Press press{draw_place(held, object, config, places), 0, k};
      if (config.force) press.force = forces.log_uniform(config.force->low, config.force->high);
      pool.push_back(std::move(press));
    }
    held.pools.push_back(std::move(pool));
  }
}

/// So many different ones of a pool.
std::vector<Press> choose(std::vector<Press> pool, int count, core::RandomStream& random) {
  std::vector<Press> chosen;
  for (int k = 0; k < count; ++k) {
    const auto one = pool.begin() + static_cast<std::ptrdiff_t>(random.index(pool.size()));
    chosen.push_back(std::move(*one));
    pool.erase(one);
  }
  return chosen;
}

}  // namespace

namespace {

/// What of the surface is sought in to find the places.
struct Seeking {
  std::optional<synth::modal::SurfaceSampler> sampler;
  std::vector<synth::surface::SurfaceTriangle> triangles;
};

Seeking seeking(const solvers::modes::ModeSurface& surface, const SupportsConfig& supports) {
  Seeking found;
  const auto& contacts = supports.contacts;
  if (std::any_of(contacts.begin(), contacts.end(),
                  [](const auto& c) { return c.place != Place::lowest; })) {
    found.sampler.emplace(surface);
  }
  if (std::any_of(contacts.begin(), contacts.end(), [](const auto& c) { return c.radius > 0; })) {
    found.triangles = synth::surface::outer_pieces(surface);
  }
  return found;
}

/// Contacts of each place of an entry whose places are not drawn.
std::vector<std::vector<synth::support::Contact>> contacts_of(const RingingObject& object,
                                                              const Seeking& in,
                                                              const SupportConfig& config) {
  const solvers::modes::ModeSurface& surface = object.modes->surface;
  std::vector<std::vector<synth::support::Contact>> places;
  switch (config.place) {
    case Place::at:
      for (const Vec3& point : config.points) {
        places.push_back(synth::support::patch_contacts(
            surface, in.triangles, nearest(object, *in.sampler, point, "at"), config.radius));
      }
      break;
    case Place::random:
      break;
    case Place::lowest:
      places.push_back(synth::support::lowest_contacts(surface, config.down, config.height));
      break;
    case Place::along: {
      std::vector<Vec3> line;
      for (const Vec3& corner : config.points) {
        nearest(object, *in.sampler, corner, "along");
        line.push_back(object.centre + corner);
      }
      places.push_back(synth::support::edge_contacts(surface, *in.sampler, line, config.count));
      break;
    }
  }
  return places;
}

}  // namespace

HeldPlaces find_places(const RingingObject& object, const SupportsConfig& supports) {
  HeldPlaces held;
  // On springs the motion as a whole is among the modes.
  if (object.modes->certificate.components <= 1 && !object.held)
    held.rigid = synth::surface::rigid_body(*object.modes);
  Seeking found = seeking(object.modes->surface, supports);
  for (const SupportConfig& config : supports.contacts) {
    for (const auto& contacts : contacts_of(object, found, config)) {
      held.fixed.push_back(hold_of(object, held, config, contacts));
    }
  }
  held.sampler = std::move(found.sampler);
  held.triangles = std::move(found.triangles);
  return held;
}

Eigen::MatrixXd find_springs(const RingingObject& object, const SupportsConfig& supports,
                             const synth::surface::RigidBody& rigid) {
  const Seeking found = seeking(object.modes->surface, supports);
  const auto rows = static_cast<Eigen::Index>(object.modes->size()) + 6;
  Eigen::MatrixXd springs(rows, 0);
  for (const SupportConfig& config : supports.contacts) {
    if (!config.kind.gives_way()) continue;
    for (const auto& contacts : contacts_of(object, found, config)) {
      const double stiffness = config.kind.spring(synth::support::area_of(contacts));
      const Eigen::MatrixXd factor =
          synth::support::contact_factor(*object.modes, contacts, config.kind.shear, &rigid);
      springs.conservativeResize(Eigen::NoChange, springs.cols() + factor.cols());
      springs.rightCols(factor.cols()) = std::sqrt(stiffness) * factor;
    }
  }
  return springs;
}

std::vector<Press> press(HeldPlaces& held, const SupportsConfig& supports,
                         const RingingObject& object, SoundKey key) {
  if (supports.pooled() && held.pools.empty()) draw_pools(held, supports, object, key.seed);
  core::RandomStream places(key.seed, key.id, "supports.place");
  core::RandomStream choices(key.seed, key.id, "supports.pool");
  core::RandomStream forces(key.seed, key.id, "supports.force");
  core::RandomStream there(key.seed, key.id, "supports.probability");
  std::vector<Press> presses;
  std::vector<std::size_t> weighed;  // they bear the object
  auto fixed = held.fixed.begin();
  auto pool = held.pools.begin();
  for (const SupportConfig& config : supports.contacts) {
    const bool acts = config.probability == 1 || there.uniform(0, 1) < config.probability;
    std::vector<Press> holds;
    if (config.pool > 0) {
      holds = choose(*pool++, config.count, choices);
    } else {
      for (int k = 0; k < config.holds(); ++k) {
        Press one;
        one.hold =
            config.place == Place::random ? draw_place(held, object, config, places) : *fixed++;
        if (config.force) one.force = forces.log_uniform(config.force->low, config.force->high);
        holds.push_back(std::move(one));
      }
    }
    for (Press& one : holds) {
      if (!acts) one.force = 0;
      if (acts && !config.force) weighed.push_back(presses.size());
      presses.push_back(std::move(one));
    }
  }
  for (const std::size_t i : weighed) {
    presses[i].force = synth::support::weight(*object.modes) / static_cast<double>(weighed.size());
  }
  return presses;
}

}  // namespace carillon::scene
