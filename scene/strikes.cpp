#include "scene/strikes.hpp"

#include <algorithm>
#include <limits>

#include "synth/modal/ring_down.hpp"

namespace carillon::scene {

core::RandomStream strike_places(std::uint64_t seed, std::uint64_t place) {
  return {seed, place, "strike.position"};
}

void draw_strike(const StrikeConfig& strikes, const solvers::modes::ModeSurface& surface,
                 const synth::modal::SurfaceSampler& sampler, const StrikeDraw& draw,
                 const KnownStrike& known, Sound& sound) {
  synth::modal::Strike& strike = sound.strike;
  core::RandomStream place = strike_places(draw.seed, draw.place);
  strike.point = known.position ? sampler.nearest(*known.position) : sampler.sample(place);
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
