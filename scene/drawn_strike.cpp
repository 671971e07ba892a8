#include "scene/drawn_strike.hpp"

#include "synth/modal/ring_down.hpp"

namespace carillon::scene {

core::RandomStream strike_places(std::uint64_t seed, std::uint64_t item) {
  return {seed, item, "strike.position"};
}

void draw_strike(const Scene& scene, std::uint64_t seed, std::uint64_t item,
                 const StrikePlace& place, Sound& sound) {
  const solvers::modes::ModeSurface& surface = sound.body->modes->surface;
  const synth::modal::SurfaceSampler sampler(surface);
  core::RandomStream drawn = strike_places(seed, item);
  synth::modal::Strike& strike = sound.strike;
  strike.point = place.at ? sampler.nearest(*place.at) : sampler.sample(drawn);
  const Vec3 inward = -synth::modal::frame_at(surface, strike.point).normal;
  strike.direction = place.direction
                         ? place.direction->normalized()
                         : synth::modal::spread_direction(inward, scene.strikes.spread, drawn);
  core::RandomStream force(seed, item, "strike.force");
  strike.impulse = force.log_uniform(scene.strikes.impulse.low, scene.strikes.impulse.high);
  sound.contact_time =
      force.log_uniform(scene.strikes.contact_time.low, scene.strikes.contact_time.high);
}

}  // namespace carillon::scene
