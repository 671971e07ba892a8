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

Metric checked_metric(const EstimateArguments& arguments, bool struck, std::size_t recorded,
                      bool output) {
  if (arguments.metric == "pitches") {
    if (output) throw InputError("--output needs --metric hybrid: pitches tell nothing of levels");
    if (!arguments.contact_time.empty()) {
      throw InputError("--contact-time needs --metric hybrid: pitches tell nothing of the contact");
    }
    return Metric::pitches;
  }
  if (arguments.metric != "hybrid") {
    throw InputError(fmt::format("\"{}\" is no metric", arguments.metric), "pitches or hybrid");
  }
  if (!struck) throw InputError("--metric hybrid compares amplitudes and needs --at");
  if (recorded > 1) throw InputError("--metric hybrid takes one recording");
  return Metric::hybrid;
}

std::vector<double> poisson_ratios(const std::string& named, const EstimateArguments& arguments) {
  if (!named.empty() || !arguments.poisson_ratio.empty() || arguments.metric == "hybrid") {
    return {assumed_material(named, arguments).elastic.poisson_ratio};
  }
  std::vector<double> ratios;
  for (int step = 1; step <= 9; ++step) ratios.push_back(0.05 * step);
  return ratios;
}

synth::material::Material assumed_material(const std::string& named,
                                           const EstimateArguments& arguments) {
  std::optional<double> ratio =
      given_quantity(arguments.poisson_ratio, Dimension::none, "--poisson-ratio");
  // All are tried: the mesh is chosen by one in the middle.
  if (!ratio && named.empty() && arguments.metric == "pitches") ratio = 0.3;
  return assumed_material(named, ratio, known_density(arguments));
}

std::optional<double> known_density(const EstimateArguments& arguments) {
  return given_quantity(arguments.density, Dimension::density, "--density");
}

HeardRecording listen(std::vector<double> samples, double sample_rate,
                      const EstimateArguments& arguments, const std::string& name) {
  HeardRecording recording;
  recording.samples = std::move(samples);
  features::FeatureArguments how;
  how.onset = arguments.onset;
  how.rt60 = arguments.rt60;
  // Weak partials have pitches, too, and what is no mode's finds none.
  how.min_level = -60;
  how.max_features = 300;
  const features::FeatureOptions options = features::feature_options(how);
  recording.rt60 = options.rt60;
  recording.set = features::extract_features(recording.samples, sample_rate, options);
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

PitchEstimate estimate_from_recordings(std::span<const HeardRecording> recordings,
                                       std::span<const solvers::modes::Modes> modes,
                                       std::span<const double> ratios,
                                       const synth::material::Material& assumed,
                                       const std::optional<StruckPlace>& place,
                                       const damping::DampingLaw& law, core::Trace& trace) {
  const core::ScopedTimer timer(trace.stages["search"]);
  const double modulus = assumed.elastic.youngs_modulus / assumed.elastic.density;
  std::vector<ModePitches> pitches;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    std::optional<synth::modal::Strike> strike;
    if (place) strike = unit_strike(modes[i], place->at, place->direction);
    pitches.push_back(mode_pitches(modes[i], modulus, ratios[i], strike));
  }
  std::vector<features::FeatureSet> sets;
  for (const HeardRecording& recording : recordings) sets.push_back(recording.set);
  const std::vector<double> rt60 =
      recordings.empty() ? std::vector<double>() : recordings.front().rt60;
  PitchEstimate estimate = estimate_from_pitches(sets, pitches, law, rt60);
  for (const features::FeatureSet& set : sets) {
    estimate.remarks.insert(estimate.remarks.begin(), set.remarks.begin(), set.remarks.end());
  }
  return estimate;
}

}  // namespace carillon::eval::material
