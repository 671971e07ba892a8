#include "eval/material/estimate_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/json.hpp"

namespace carillon::eval::material {

namespace {

nlohmann::json json_of(const Candidate& candidate, const MetricValue& value) {
  nlohmann::json parameters = nlohmann::json::object();
  for (std::size_t k = 0; k < candidate.damping.parameters.size(); ++k) {
    parameters[synth::damping::parameter_name(k)] = candidate.damping.parameters[k];
  }
  return {{"specific_modulus_m2_per_s2", candidate.specific_modulus},
          {"scale", candidate.scale},
          {"contact_time_s", candidate.contact_time},
          {"parameters", parameters},
          {"metric", value.metric},
          {"psychoacoustic_difference", value.psychoacoustic},
          {"recording_match", value.recording_match},
          {"candidate_match", value.candidate_match}};
}

}  // namespace

nlohmann::json to_json(const MaterialEstimate& estimate, const features::FeatureSet& recording,
                       const std::optional<double>& density, const core::Trace& trace) {
  nlohmann::json json = json_of(estimate.candidate, estimate.value);
  for (std::size_t k = 0; k < estimate.ranges.size(); ++k) {
    json["parameters"]["range"][synth::damping::parameter_name(k)] = {
        core::number_or_null(estimate.ranges[k].low),
        core::number_or_null(estimate.ranges[k].high)};
  }
  json["model"] = synth::damping::formula_of(estimate.candidate.damping);
  json["specific_modulus_error"] = core::number_or_null(estimate.modulus_error);
  json["frequency_rms_cents"] = estimate.rms_cents;
  if (density) {
    json["youngs_modulus_pa"] = estimate.candidate.specific_modulus * *density;
    json["density_kg_m3"] = *density;
  }
  for (const LocalMinimum& minimum : estimate.minima) {
    json["minima"].push_back(json_of(minimum.candidate, minimum.value));
  }
  json["matches"] = nlohmann::json::array();
  for (const MatchedFeature& match : estimate.matches) {
    const features::Feature& feature = recording.features[match.feature];
    json["matches"].push_back({{"frequency_hz", feature.frequency},
                               {"decay_rate_per_s", feature.decay_rate},
                               {"amplitude", feature.amplitude},
                               {"mode_frequency_hz", match.tone.frequency},
                               {"mode_decay_rate_per_s", match.tone.decay_rate},
                               {"mode_amplitude", match.tone.amplitude},
                               {"similarity", match.similarity}});
  }
  json["features"] = recording.features.size();
  json["modes"] = estimate.tones.size();
  json["starts"] = estimate.starts;
  json["evaluations"] = estimate.evaluations;
  json["converged"] = estimate.converged;
  json["remarks"] = estimate.remarks;
  for (const auto& [stage, entry] : trace.stages) {
    json["timing"][stage + "_s"] = entry.seconds;
    json["calls"][stage] = entry.calls;
  }
  return json;
}

void print_estimate(const MaterialEstimate& estimate, const features::FeatureSet& recording,
                    const std::optional<double>& density, const core::Trace& trace) {
  const Candidate& found = estimate.candidate;
  fmt::print("{:<22} {:.5g} m^2/s^2", "specific modulus", found.specific_modulus);
  if (std::isfinite(estimate.modulus_error)) {
    fmt::print(" +- {:.2g} %", 100 * estimate.modulus_error);
  }
  fmt::print("\n");
  if (density) {
    fmt::print("{:<22} {:.5g} GPa at {:.5g} kg/m^3\n", "Young's modulus",
               1e-9 * found.specific_modulus * *density, *density);
  }
  fmt::print("{:<22} {}\n", "damping",
             found.damping.kind == synth::damping::DampingKind::expression
                 ? "c = " + found.damping.expression
                 : synth::damping::form_of(found.damping.kind).formula);
  for (std::size_t k = 0; k < found.damping.parameters.size(); ++k) {
    fmt::print("  {:<20} {:.5g} {}, alone between {:.3g} and {:.3g}\n",
               synth::damping::parameter_name(k), found.damping.parameters[k],
               synth::damping::parameter_unit(found.damping.kind, k), estimate.ranges[k].low,
               estimate.ranges[k].high);
  }
  fmt::print("{:<22} {:.4g}; contact {:.3g} ms\n", "scale", found.scale, 1000 * found.contact_time);
  fmt::print("{:<22} {:.4g}: spectrograms differ by {:.3g}, match ratios {:.3f} and {:.3f}\n",
             "metric", estimate.value.metric, estimate.value.psychoacoustic,
             estimate.value.recording_match, estimate.value.candidate_match);
  fmt::print("{:<22} {} of the recording, {} of the estimate, {:.3g} cents apart\n", "modes",
             recording.features.size(), estimate.tones.size(), estimate.rms_cents);
  for (std::size_t i = 1; i < std::min<std::size_t>(4, estimate.minima.size()); ++i) {
    const LocalMinimum& other = estimate.minima[i];
    fmt::print("{:<22} {:.5g} m^2/s^2, metric {:.4g}\n", i == 1 ? "other minima" : "",
               other.candidate.specific_modulus, other.value.metric);
  }
  for (const std::string& remark : estimate.remarks) fmt::print("- {}\n", remark);
  for (const auto& [stage, entry] : trace.stages) {
    fmt::print("{:<22} {:8.3f} s\n", stage, entry.seconds);
  }
}

}  // namespace carillon::eval::material
