#include "eval/recorded_objects/heard_body.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "synth/radiation/fit_cache.hpp"

namespace carillon::eval::recorded_objects {

namespace {

Vec3 centre_of(const solvers::modes::Modes& modes) {
  const solvers::mesh::Box box = solvers::mesh::bounding_box(modes.surface.nodes);
  return 0.5 * (box.low + box.high);
}

}  // namespace

HeardBody hear_body(const solvers::modes::Modes& modes, double assumed, double specific_modulus,
                    const std::vector<ModelBlow>& blows, bool radiation,
                    const std::filesystem::path& cache) {
  HeardBody body;
  body.modes = solvers::modes::rescale(modes, 1, specific_modulus / assumed, 1);
  body.specific_modulus = specific_modulus;
  if (!radiation) return body;
  synth::radiation::EquivalentSources fit = synth::radiation::cached_equivalent_sources(
      body.modes, {}, cache.empty() ? cache : cache / "radiation");
  body.radiated = fit.decay_rates;
  body.doubtful = static_cast<std::size_t>(
      std::count_if(fit.residuals.begin(), fit.residuals.end(),
                    [](double residual) { return residual > synth::radiation::kResidualLimit; }));
  std::vector<synth::modal::Listener> listeners;
  for (const ModelBlow& blow : blows) listeners.push_back(blow.listener);
  body.pressure = synth::radiation::SourceField(std::move(fit)).pressure_at(listeners);
  return body;
}

void keep_blows(const std::vector<std::size_t>& kept, std::vector<ModelBlow>& blows,
                HeardBody& body) {
  std::vector<ModelBlow> left;
  for (const std::size_t blow : kept) left.push_back(blows[blow]);
  blows = std::move(left);
  if (!body.pressure) return;
  synth::radiation::ModalPressure pressure{body.pressure->pressure(kept, Eigen::all), {}};
  for (const std::size_t blow : kept) pressure.delays.push_back(body.pressure->delays[blow]);
  body.pressure = std::move(pressure);
}

material::StruckModes struck_by(const HeardBody& body, const std::vector<ModelBlow>& blows,
                                std::size_t blow) {
  const ModelBlow& blown = blows[blow];
  return body.pressure
             ? material::radiated_modes(body.modes, blown.point, blown.direction,
                                        body.specific_modulus, *body.pressure, blow, body.radiated)
             : material::struck_modes(body.modes, blown.point, blown.direction,
                                      body.specific_modulus);
}

double arrival(const HeardBody& body, const std::vector<ModelBlow>& blows, std::size_t blow) {
  if (body.pressure) return body.pressure->delays[blow];
  return (blows[blow].listener.position - centre_of(body.modes)).norm() / synth::modal::kSoundSpeed;
}

std::vector<double> synthetic_recording(const HeardBody& body, const std::vector<ModelBlow>& blows,
                                        std::size_t blow,
                                        const synth::damping::DampingModel& damping,
                                        double sample_rate, std::size_t count) {
  auto decay = synth::damping::clamped_decay_rates(body.modes, std::vector{damping});
  for (std::size_t i = 0; i < body.radiated.size(); ++i) decay.values[i] += body.radiated[i];
  synth::modal::Readout readout;
  if (body.pressure) {
    const auto row = static_cast<Eigen::Index>(blow);
    const synth::radiation::ModalPressure one{body.pressure->pressure.row(row),
                                              {body.pressure->delays[blow]}};
    readout = synth::radiation::pressure_readout(one, body.modes, decay.values);
  } else {
    readout = synth::modal::point_velocity(body.modes, blows[blow].point);
    readout.velocity.swap(readout.acceleration);
    readout.delays = {arrival(body, blows, blow)};
  }
  const synth::modal::Strike strike{
      .point = blows[blow].point, .direction = blows[blow].direction, .impulse = 1, .force = {}};
  synth::modal::RingDown rings = synth::modal::ring_down(body.modes, decay.values, strike, readout);
  synth::modal::leave_out(rings, decay.negative);
  const std::vector<float> sound =
      synth::modal::synthesize(rings, strike.force, sample_rate, count);
  return {sound.begin(), sound.end()};
}

}  // namespace carillon::eval::recorded_objects
