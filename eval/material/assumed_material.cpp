#include "eval/material/assumed_material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::eval::material {

synth::material::Material assumed_material(const std::string& named,
                                           const std::optional<double>& poisson_ratio,
                                           const std::optional<double>& density) {
  if (named.empty() && !poisson_ratio) {
    throw core::InputError("Poisson's ratio cannot be heard and must be given",
                           "give poisson_ratio, 0.3 for example, or a preset that has it as the "
                           "material");
  }
  synth::material::Material material = synth::material::parse_material(
      named.empty() ? fmt::format("youngs_modulus=70 GPa,poisson_ratio={},density=2500 kg/m^3",
                                  *poisson_ratio)
                    : named);
  if (poisson_ratio) material.elastic.poisson_ratio = *poisson_ratio;
  if (density) material.elastic.density = *density;
  material.damping = {};
  synth::material::check_material(material);
  return material;
}

synth::modal::Strike unit_strike(const solvers::modes::Modes& modes, const Vec3& at,
                                 const std::optional<Vec3>& direction) {
  synth::modal::Strike strike;
  strike.point = synth::modal::SurfaceSampler(modes.surface).nearest(at);
  strike.direction = direction ? Vec3(direction->normalized())
                               : Vec3(-synth::modal::frame_at(modes.surface, strike.point).normal);
  strike.impulse = 1;
  return strike;
}

core::AudioClip resynthesis(std::span<const double> samples, const features::FeatureSet& set,
                            const solvers::modes::Modes& modes, synth::modal::Strike strike,
                            const Candidate& estimate, double assumed_modulus, HeardMotion motion) {
  const solvers::modes::Modes scaled =
      solvers::modes::rescale(modes, 1, estimate.specific_modulus / assumed_modulus, 1);
  synth::modal::Readout readout = synth::modal::point_velocity(scaled, strike.point);
  if (motion == HeardMotion::displacement) readout.velocity.swap(readout.displacement);
  if (motion == HeardMotion::acceleration) readout.velocity.swap(readout.acceleration);
  strike.impulse = estimate.scale;
  strike.force = {.duration = estimate.contact_time};
  const auto decay = synth::damping::clamped_decay_rates(scaled, std::vector{estimate.damping});
  synth::modal::RingDown rings = synth::modal::ring_down(scaled, decay.values, strike, readout);
  synth::modal::leave_out(rings, decay.negative);
  const double rate = set.sample_rate;
  const std::size_t onset =
      std::min(samples.size(), static_cast<std::size_t>(std::lround(set.onset * rate)));
  const auto sound = synth::modal::synthesize(rings, strike.force, rate, samples.size() - onset);
  core::AudioClip clip;
  clip.sample_rate = static_cast<int>(rate);
  clip.samples.assign(onset, 0.0F);
  clip.samples.insert(clip.samples.end(), sound.begin(), sound.end());
  return clip;
}

}  // namespace carillon::eval::material
