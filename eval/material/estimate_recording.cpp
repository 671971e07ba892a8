#include "eval/material/estimate_recording.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/units.hpp"
#include "eval/damping/law_text.hpp"
#include "eval/features/feature_arguments.hpp"
#include "eval/material/assumed_material.hpp"

namespace carillon::eval::material {

namespace {

using core::Dimension;
using core::InputError;

std::optional<double> given_quantity(const std::string& text, Dimension dimension,
                                     const char* option) {
  if (text.empty()) return std::nullopt;
  try {
    return core::parse_quantity(text, dimension);
  } catch (const core::Error& error) {
    throw InputError(fmt::format("{}: {}", option, error.message()), error.hint());
  }
}

}  // namespace

MaterialOptions material_options(const EstimateArguments& arguments) {
  MaterialOptions options;
  options.law = damping::damping_law(arguments.model);
  options.motion = parse_heard_motion(arguments.heard);
  options.contact_time = given_quantity(arguments.contact_time, Dimension::time, "--contact-time");
  if (options.contact_time && !(*options.contact_time >= 0)) {
    throw InputError("--contact-time must not be negative");
  }
  if (arguments.starts < 1 || arguments.starts > EstimateArguments::max_starts) {
    throw InputError(fmt::format("--starts: {} lies outside 1 to {}", arguments.starts,
                                 EstimateArguments::max_starts));
  }
  options.searches = arguments.starts;
  options.starts.seed = arguments.seed;
  return options;
}

synth::material::Material assumed_material(const std::string& named,
                                           const EstimateArguments& arguments) {
  return assumed_material(
      named, given_quantity(arguments.poisson_ratio, Dimension::none, "--poisson-ratio"),
      known_density(arguments));
}

std::optional<double> known_density(const EstimateArguments& arguments) {
  return given_quantity(arguments.density, Dimension::density, "--density");
}

HeardRecording listen(std::vector<double> samples, double sample_rate,
                      const EstimateArguments& arguments, const std::string& name) {
  HeardRecording recording;
  recording.samples = std::move(samples);
  recording.set = features::extract_features(
      recording.samples, sample_rate,
      features::feature_options({.onset = arguments.onset, .rt60 = arguments.rt60}));
  if (recording.set.features.empty()) {
    throw InputError(fmt::format("{}: no modes can be heard: {}", name, recording.set.nothing),
                     "a material is estimated from a struck object's ringing");
  }
  return recording;
}

StruckPlace struck_place(const Vec3& at, const std::optional<Vec3>& direction) {
  if (direction && !(direction->norm() > 0)) throw InputError("--direction has no length");
  return {at, direction};
}

RecordedMaterial estimate_recording(const HeardRecording& recording,
                                    const solvers::modes::Modes& modes,
                                    std::span<const synth::material::Material> materials,
                                    const StruckPlace& place, const MaterialOptions& options,
                                    const std::string& object, core::Trace& trace) {
  if (materials.size() != 1) {
    throw InputError(fmt::format("{} has {} regions", object, materials.size()),
                     "one material is estimated: give an object of one region");
  }
  const solvers::elements::Elastic& elastic = materials.front().elastic;
  const double modulus = elastic.youngs_modulus / elastic.density;
  const synth::modal::Strike strike = unit_strike(modes, place.at, place.direction);
  RecordedMaterial found;
  {
    const core::ScopedTimer timer(trace.stages["search"]);
    found.estimate =
        estimate_material(recording.samples, recording.set,
                          struck_modes(modes, strike.point, strike.direction, modulus), options);
  }
  found.estimate.remarks.insert(found.estimate.remarks.begin(), recording.set.remarks.begin(),
                                recording.set.remarks.end());
  found.resynthesis = resynthesis(recording.samples, recording.set, modes, strike,
                                  found.estimate.candidate, modulus, options.motion);
  return found;
}

}  // namespace carillon::eval::material
