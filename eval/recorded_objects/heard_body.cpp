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
                    const std::vector<ModelStrike>& strikes, bool radiation,
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
  for (const ModelStrike& strike : strikes) listeners.push_back(strike.listener);
  body.pressure = synth::radiation::SourceField(std::move(fit)).pressure_at(listeners);
  return body;
}

void keep_strikes(const std::vector<std::size_t>& kept, std::vector<ModelStrike>& strikes,
                  HeardBody& body) {
  std::vector<ModelStrike> left;
  for (const std::size_t strike : kept) left.push_back(strikes[strike]);
  strikes = std::move(left);
  if (!body.pressure) return;
  synth::radiation::ModalPressure pressure{body.pressure->pressure(kept, Eigen::all), {}};
  for (const std::size_t strike : kept) pressure.delays.push_back(body.pressure->delays[strike]);
  body.pressure = std::move(pressure);
}

material::StruckModes struck_by(const HeardBody& body, const std::vector<ModelStrike>& strikes,
                                std::size_t number) {
  const ModelStrike& struck = strikes[number];
  return body.pressure ? material::radiated_modes(body.modes, struck.point, struck.direction,
                                                  body.specific_modulus, *body.pressure, number,
                                                  body.radiated)
                       : material::struck_modes(body.modes, struck.point, struck.direction,
                                                body.specific_modulus);
}

double arrival(const HeardBody& body, const std::vector<ModelStrike>& strikes, std::size_t number) {
  if (body.pressure) return body.pressure->delays[number];
  return (strikes[number].listener.position - centre_of(body.modes)).norm() /
         synth::modal::kSoundSpeed;
}

std::vector<double> synthetic_recording(const HeardBody& body,
                                        const std::vector<ModelStrike>& strikes, std::size_t number,
                                        const synth::damping::DampingModel& damping,
                                        double sample_rate, std::size_t count) {
  auto decay = synth::damping::clamped_decay_rates(body.modes, std::vector{damping});
  for (std::size_t i = 0; i < body.radiated.size(); ++i) decay.values[i] += body.radiated[i];
  synth::modal::Readout readout;
  if (body.pressure) {
    const auto row = static_cast<Eigen::Index>(number);
    const synth::radiation::ModalPressure one{body.pressure->pressure.row(row),
                                              {body.pressure->delays[number]}};
    readout = synth::radiation::pressure_readout(one, body.modes, decay.values);
  } else {
    readout = synth::modal::point_velocity(body.modes, strikes[number].point);
    readout.velocity.swap(readout.acceleration);
    readout.delays = {arrival(body, strikes, number)};
  }
  const synth::modal::Strike strike{.point = strikes[number].point,
                                    .direction = strikes[number].direction,
                                    .impulse = 1,
                                    .force = {}};
  synth::modal::RingDown rings = synth::modal::ring_down(body.modes, decay.values, strike, readout);
  synth::modal::leave_out(rings, decay.negative);
  const std::vector<float> sound =
      synth::modal::synthesize(rings, strike.force, sample_rate, count);
  return {sound.begin(), sound.end()};
}

}  // namespace carillon::eval::recorded_objects
