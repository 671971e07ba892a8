#include "scene/strikes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::scene {

core::RandomStream strike_places(std::uint64_t seed, std::uint64_t place) {
  return {seed, place, "strike.position"};
}

synth::modal::SurfacePoint nearest_point(const synth::modal::SurfaceSampler& sampler,
                                         const solvers::modes::ModeSurface& surface,
                                         const Vec3& position, double tolerance) {
  const synth::modal::SurfacePoint point = sampler.nearest(position);
  const Vec3 nearest = synth::modal::frame_at(surface, point).position;
  const double distance = (nearest - position).norm();
  Vec3 low = nearest, high = nearest;
  for (const Vec3& node : surface.nodes) {
    low = low.cwiseMin(node);
    high = high.cwiseMax(node);
  }
  if (distance <= tolerance * (high - low).maxCoeff()) return point;
  const auto text = [](const Vec3& at) {
    const auto rounded = [](double x) { return std::abs(x) < 1e-9 ? 0.0 : x; };
    return fmt::format("({:.4g}, {:.4g}, {:.4g}) m", rounded(at.x()), rounded(at.y()),
                       rounded(at.z()));
  };
  throw core::InputError(
      fmt::format("the point struck, {}, is {:.4g} m off the object; the nearest on it is {}",
                  text(position), distance, text(nearest)),
      fmt::format("points are in metres in the object's own coordinates, which go from {} to {}",
                  text(low), text(high)));
}

void draw_strike(const StrikeConfig& strikes, const solvers::modes::ModeSurface& surface,
                 const synth::modal::SurfaceSampler& sampler, const StrikeDraw& draw,
                 const KnownStrike& known, Sound& sound) {
  synth::modal::Strike& strike = sound.strike;
  core::RandomStream place = strike_places(draw.seed, draw.place);
  strike.point = known.position ? nearest_point(sampler, surface, *known.position, known.tolerance)
                                : sampler.sample(place);
  const Vec3 inward = -synth::modal::frame_at(surface, strike.point).normal;
  strike.direction = known.direction
                         ? *known.direction
                         : synth::modal::spread_direction(inward, strikes.spread, place);
  if (known.force) {
    strike.impulse = 1;
    strike.force = *known.force;
    sound.contact_time = known.force->duration;
    return;
  }
  core::RandomStream force(draw.seed, draw.force, "strike.force");
  const auto drawn = [&](const core::Range& range) {
    return force.log_uniform(range.low, range.high);
  };
  strike.impulse = known.impulse ? *known.impulse : drawn(strikes.impulse);
  sound.contact_time = known.contact_time ? *known.contact_time : drawn(strikes.contact_time);
}

std::vector<synth::modal::SurfacePoint> spread_points(const synth::modal::SurfaceSampler& sampler,
                                                      const solvers::modes::ModeSurface& surface,
                                                      std::size_t count,
                                                      core::RandomStream& places) {
  constexpr std::size_t drawn_for_each = 64;
  std::vector<synth::modal::SurfacePoint> drawn(drawn_for_each * count);
  std::vector<Vec3> positions;
  for (synth::modal::SurfacePoint& point : drawn) {
    point = sampler.sample(places);
    positions.push_back(synth::modal::frame_at(surface, point).position);
  }
  std::vector<double> distances(drawn.size(), std::numeric_limits<double>::infinity());
  std::vector<synth::modal::SurfacePoint> chosen;
  std::size_t next = 0;
  while (chosen.size() < count) {
    chosen.push_back(drawn[next]);
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      distances[i] = std::min(distances[i], (positions[i] - positions[next]).norm());
    }
    next = std::size_t(std::max_element(distances.begin(), distances.end()) - distances.begin());
  }
  return chosen;
}

}  // namespace carillon::scene
