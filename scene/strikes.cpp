#include "scene/strikes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/error.hpp"
#include "core/numbers.hpp"
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

std::size_t samples_before(const Repeats& repeats, double sample_rate) {
  return static_cast<std::size_t>(std::ceil(repeats.lead() * sample_rate));
}

void draw_repeats(const Repeats& repeats, double sample_rate, Sound& sound) {
  if (!repeats.any()) return;
  core::RandomStream random(sound.seed, sound.id, "strike.repeats");
  const auto count = [&](const core::Range& range) {
    return static_cast<std::uint64_t>(range.low) +
           random.index(static_cast<std::uint64_t>(range.high - range.low) + 1);
  };
  const std::uint64_t earlier = count(repeats.earlier), later = count(repeats.later);
  const auto pause = [&] {
    return random.log_uniform(repeats.interval.low, repeats.interval.high);
  };
  std::vector<double> times = {0};
  for (std::uint64_t i = 0; i < earlier; ++i) times.insert(times.begin(), times.front() - pause());
  for (std::uint64_t i = 0; i < later; ++i) times.push_back(times.back() + pause());
  sound.before = samples_before(repeats, sample_rate);
  sound.strikes.clear();
  for (const double time : times)
    sound.strikes.push_back(static_cast<double>(sound.before) / sample_rate + time);
  if (sound.record == nullptr) return;
  times.resize(1 + static_cast<std::size_t>(repeats.earlier.high + repeats.later.high), core::nan);
  sound.record->add("strike_times", std::span<const double>(times), {times.size()});
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
