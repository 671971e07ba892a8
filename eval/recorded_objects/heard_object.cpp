#include "eval/recorded_objects/heard_object.hpp"

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

HeardObject hear_object(const solvers::modes::Modes& modes, double assumed, double specific_modulus,
                        const std::vector<ModelStrike>& strikes, bool radiation,
                        const std::filesystem::path& cache) {
  HeardObject object;
  object.modes = solvers::modes::rescale(modes, 1, specific_modulus / assumed, 1);
  object.specific_modulus = specific_modulus;
  if (!radiation) return object;
  synth::radiation::EquivalentSources fit = synth::radiation::cached_equivalent_sources(
      object.modes, {}, cache.empty() ? cache : cache / "radiation");
  object.radiated = fit.decay_rates;
  object.doubtful = static_cast<std::size_t>(
      std::count_if(fit.residuals.begin(), fit.residuals.end(),
                    [](double residual) { return residual > synth::radiation::residual_limit; }));
  std::vector<synth::modal::Listener> listeners;
  for (const ModelStrike& strike : strikes) listeners.push_back(strike.listener);
  object.pressure = synth::radiation::SourceField(std::move(fit)).pressure_at(listeners);
  return object;
}

void keep_strikes(const std::vector<std::size_t>& kept, std::vector<ModelStrike>& strikes,
                  HeardObject& object) {
  std::vector<ModelStrike> left;
  for (const std::size_t strike : kept) left.push_back(strikes[strike]);
  strikes = std::move(left);
  if (!object.pressure) return;
  synth::radiation::ModalPressure pressure{object.pressure->pressure(kept, Eigen::all), {}};
  for (const std::size_t strike : kept) pressure.delays.push_back(object.pressure->delays[strike]);
  object.pressure = std::move(pressure);
}

material::StruckModes struck_by(const HeardObject& object, const std::vector<ModelStrike>& strikes,
                                std::size_t number) {
  const ModelStrike& struck = strikes[number];
  return object.pressure ? material::radiated_modes(object.modes, struck.point, struck.direction,
                                                    object.specific_modulus, *object.pressure,
                                                    number, object.radiated)
                         : material::struck_modes(object.modes, struck.point, struck.direction,
                                                  object.specific_modulus);
}

double arrival(const HeardObject& object, const std::vector<ModelStrike>& strikes,
               std::size_t number) {
  if (object.pressure) return object.pressure->delays[number];
  return (strikes[number].listener.position - centre_of(object.modes)).norm() /
         synth::modal::speed_of_sound;
}

std::vector<double> synthetic_recording(const HeardObject& object,
                                        const std::vector<ModelStrike>& strikes, std::size_t number,
                                        const synth::damping::DampingModel& damping,
                                        double sample_rate, std::size_t count) {
  auto decay = synth::damping::clamped_decay_rates(object.modes, std::vector{damping});
  for (std::size_t i = 0; i < object.radiated.size(); ++i) decay.values[i] += object.radiated[i];
  synth::modal::Readout readout;
  if (object.pressure) {
    const auto row = static_cast<Eigen::Index>(number);
    const synth::radiation::ModalPressure one{object.pressure->pressure.row(row),
                                              {object.pressure->delays[number]}};
    readout = synth::radiation::pressure_readout(one, object.modes, decay.values);
  } else {
    readout = synth::modal::point_velocity(object.modes, strikes[number].point);
    readout.velocity.swap(readout.acceleration);
    readout.delays = {arrival(object, strikes, number)};
  }
  const synth::modal::Strike strike{.point = strikes[number].point,
                                    .direction = strikes[number].direction,
                                    .impulse = 1,
                                    .force = {.duration = strikes[number].contact_time}};
  synth::modal::RingDown rings =
      synth::modal::ring_down(object.modes, decay.values, strike, readout);
  synth::modal::leave_out(rings, decay.negative);
  const std::vector<float> sound =
      synth::modal::synthesize(rings, strike.force, sample_rate, count);
  return {sound.begin(), sound.end()};
}

}  // namespace carillon::eval::recorded_objects
