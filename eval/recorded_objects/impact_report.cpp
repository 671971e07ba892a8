#include "eval/recorded_objects/impact_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/json.hpp"
#include "eval/damping/fitted_alphas.hpp"

namespace carillon::eval::recorded_objects {

namespace {

using nlohmann::json;

json spread_json(const recorded::Spread& spread) {
  return {{"median", core::number_or_null(spread.median)},
          {"tenth", core::number_or_null(spread.low)},
          {"nine_tenths", core::number_or_null(spread.high)}};
}

json mode_json(const features::Feature& mode) {
  return {{"frequency_hz", mode.frequency},
          {"decay_rate_per_s", core::number_or_null(mode.decay_rate)},
          {"amplitude", core::number_or_null(mode.amplitude)}};
}

json peaks_json(const recorded::PeakMatch& match) {
  std::vector<double> distances;
  for (const double cents : match.cents) distances.push_back(std::abs(cents));
  return {{"modes", match.modes},
          {"peaks", match.peaks},
          {"matched", match.matched},
          {"matched_by_chance", match.matched_by_chance},
          {"distance_cents", spread_json(recorded::spread_of(distances))},
          {"rank_rms_hz", core::number_or_null(match.rank_rms_hz)},
          {"rank_rms_cents", core::number_or_null(match.rank_rms_cents)}};
}

json summary_json(const recorded::RecordedSummary& all) {
  return {{"recorded", all.recorded},
          {"synthetic", all.synthetic},
          {"matched", all.matched},
          {"matched_by_chance", all.matched_by_chance},
          {"recorded_energy_fraction", core::number_or_null(all.recorded_fraction)},
          {"synthetic_energy_fraction", core::number_or_null(all.synthetic_fraction)},
          {"pitch_cents", spread_json(all.cents)},
          {"distance_cents", spread_json(all.distance)},
          {"decay_ratio", spread_json(all.decay_ratio)},
          {"level_error_db", spread_json(all.level_error)}};
}

json strike_json(const ImpactReport& report, const ModelVariant& variant, std::size_t strike) {
  const auto& recorded = report.strikes[strike].set.features;
  const auto& synthetic = variant.modes.synthetic[strike];
  const perception::ModeComparison& modes = variant.modes.strikes[strike];
  json matched = json::array(), only = json::array(), other = json::array();
  for (const perception::MatchedMode& pair : modes.matched) {
    matched.push_back({{"recorded", mode_json(recorded[pair.reference])},
                       {"synthetic", mode_json(synthetic[pair.other])},
                       {"pitch_cents", pair.cents},
                       {"decay_ratio", core::number_or_null(pair.decay_ratio)},
                       {"level_db", core::number_or_null(pair.level)}});
  }
  for (const std::size_t place : modes.reference_only) only.push_back(mode_json(recorded[place]));
  for (const std::size_t place : modes.other_only) other.push_back(mode_json(synthetic[place]));
  return {{"variant", variant.name},
          {"frequency_scale", variant.scales[strike]},
          {"peaks", peaks_json(variant.peaks[strike])},
          {"matched", matched},
          {"recorded_only", only},
          {"synthetic_only", other},
          {"level_db", spread_json(recorded::spread_of(levels_of(modes)))}};
}

json vertex_json(const ImpactReport& report, std::size_t strike) {
  const StudiedStrike& studied = report.strikes[strike];
  const std::size_t row = studied.recorded.row;
  const auto list = [](const Vec3& v) { return std::vector(v.begin(), v.end()); };
  json vertex = {{"vertex", studied.recorded.vertex},
                 {"row", row},
                 {"struck_m", list(report.folder.struck[row])},
                 {"direction", list(report.model[strike].direction)},
                 {"listener_m", list(report.folder.listeners[row])},
                 {"touch_s", studied.touch},
                 {"contact_time_s", report.model[strike].contact_time},
                 {"onset_s", studied.set.onset},
                 {"recorded_modes", studied.set.features.size()},
                 {"energy_explained", studied.set.explained},
                 {"remarks", studied.set.remarks},
                 {"nothing", studied.set.nothing}};
  const auto label = [&](const char* name, const std::optional<std::vector<double>>& labels) {
    if (labels) vertex[name] = (*labels)[row];
  };
  label("angle_deg", report.folder.angles);
  label("distance_mm", report.folder.distances);
  label("microphone", report.folder.microphones);
  for (const ModelVariant& variant : report.variants) {
    vertex["variants"].push_back(strike_json(report, variant, strike));
  }
  return vertex;
}

json variant_json(const ModelVariant& variant) {
  return {{"variant", variant.name},
          {"frequencies_alone", variant.frequencies_alone},
          {"frequency_scale", spread_json(recorded::spread_of(variant.scales))},
          {"peaks", peaks_json(recorded::joined(variant.peaks))},
          {"modes", summary_json(variant.modes.all)},
          {"gain", core::number_or_null(variant.modes.gain)}};
}

json fit_json(const ImpactReport& report) {
  const StudyFit& fit = *report.fit;
  json alone = json::array();
  for (const auto& one : fit.alone) alone.push_back(one ? json(*one) : json(nullptr));
  json out = {{"metric", fit.joint ? "hybrid" : "pitches"},
              {"undetermined", fit.undetermined},
              {"specific_modulus_of_each_vertex", alone},
              {"log_likelihood_as_given", fit.log_likelihood_given},
              {"remarks", fit.remarks}};
  if (!fit.specific_modulus) {
    out["specific_modulus_m2_per_s2"] = nullptr;
    return out;
  }
  const double density = report.material.elastic.density;
  out["specific_modulus_m2_per_s2"] = *fit.specific_modulus;
  if (fit.modulus95) {
    out["specific_modulus_95_m2_per_s2"] = {fit.modulus95->low, fit.modulus95->high};
  }
  out["specific_modulus_ratio"] = *fit.specific_modulus / report.given.specific_modulus;
  out["youngs_modulus_pa"] = *fit.specific_modulus * density;
  out["density_kg_m3"] = density;
  out["poisson_ratio"] = report.material.elastic.poisson_ratio;
  out["log_likelihood"] = fit.log_likelihood;
  out["model"] = synth::damping::formula_of(fit.damping);
  out["parameters"] = damping::alphas_json(fit.damping, fit.confidence95);
  out["damping_points"] = fit.points;
  if (fit.joint) {
    out["joint_model"] = synth::damping::formula_of(fit.joint->candidate.damping);
    out["hybrid_metric"] = fit.joint->metric;
    out["evaluations"] = fit.joint->evaluations;
  }
  return out;
}

}  // namespace

std::vector<double> levels_of(const perception::ModeComparison& modes) {
  std::vector<double> levels;
  for (const perception::MatchedMode& pair : modes.matched) {
    if (!std::isnan(pair.level)) levels.push_back(pair.level);
  }
  return levels;
}

json to_json(const ImpactReport& report) {
  json out = {{"object", report.folder.name},
              {"mesh", report.folder.mesh.string()},
              {"material", report.material.name},
              {"deconvolved", report.folder.deconvolved},
              {"recordings", report.folder.rows()},
              {"samples", report.folder.samples()},
              {"sample_rate_hz", report.options.sample_rate},
              {"stretch_samples", {report.options.stretch.first, report.options.stretch.end}},
              {"modes", report.given.modes.size()},
              {"complete_to_hz", report.given.modes.certificate.complete_to_hz},
              {"specific_modulus_given_m2_per_s2", report.given.specific_modulus},
              {"radiation", report.options.radiation ? "equivalent_sources" : "off"},
              {"radiation_doubtful_modes", report.given.doubtful},
              {"levels", report.options.radiation ? "relative to one gain of all recordings"
                                                  : "not physical: no radiation"},
              {"remarks", report.remarks}};
  for (const ModelVariant& variant : report.variants)
    out["variants"].push_back(variant_json(variant));
  if (report.fit) out["fit"] = fit_json(report);
  for (std::size_t i = 0; i < report.strikes.size(); ++i) {
    out["vertices"].push_back(vertex_json(report, i));
  }
  for (const auto& [stage, entry] : report.trace.stages) {
    out["timing"][stage + "_s"] = entry.seconds;
  }
  return out;
}

}  // namespace carillon::eval::recorded_objects
