#include "eval/material/pitch_report.hpp"

#include <fmt/format.h>

#include "core/json.hpp"
#include "core/numbers.hpp"
#include "eval/damping/fitted_alphas.hpp"

namespace carillon::eval::material {

namespace {

nlohmann::json json_of(const core::Range& range) {
  return {core::number_or_null(range.low), core::number_or_null(range.high)};
}

nlohmann::json json_of(const MatchedTone& match) {
  return {{"frequency_hz", match.feature.frequency},
          {"decay_rate_per_s", match.feature.decay_rate},
          {"amplitude", match.feature.amplitude},
          {"mode_frequency_hz", match.mode_frequency},
          {"cents", core::cents(match.feature.frequency / match.mode_frequency)},
          {"probability", match.probability}};
}

}  // namespace

nlohmann::json to_json(const PitchEstimate& estimate, const std::optional<double>& density,
                       const core::Trace& trace) {
  nlohmann::json json = {{"metric", "pitches"},
                         {"determined", estimate.complete()},
                         {"undetermined", estimate.undetermined},
                         {"specific_modulus_m2_per_s2", nullptr},
                         {"frequency_scale", nullptr},
                         {"poisson_ratio", nullptr},
                         {"room_rt60_s", nullptr},
                         {"parameters", nullptr},
                         {"confidence95", nlohmann::json::object()},
                         {"log_evidence", estimate.log_evidence},
                         {"chance", estimate.chance},
                         {"tones", estimate.tones},
                         {"matches", nlohmann::json::array()},
                         {"remarks", estimate.remarks}};
  if (estimate.specific_modulus) {
    const double modulus = *estimate.specific_modulus;
    json["specific_modulus_m2_per_s2"] = modulus;
    json["confidence95"]["specific_modulus_m2_per_s2"] = json_of(estimate.modulus95);
    json["frequency_scale"] = *estimate.frequency_scale;
    json["confidence95"]["frequency_scale"] = json_of(estimate.scale95);
    json["scatter_cents"] = estimate.scatter_cents;
    json["sharpness"] = estimate.sharpness;
    if (density) {
      json["youngs_modulus_pa"] = modulus * *density;
      json["density_kg_m3"] = *density;
      json["confidence95"]["youngs_modulus_pa"] = json_of(
          core::Range{estimate.modulus95.low * *density, estimate.modulus95.high * *density});
    }
  }
  if (estimate.poisson_ratio) {
    json["poisson_ratio"] = *estimate.poisson_ratio;
    json["confidence95"]["poisson_ratio"] = json_of(estimate.poisson95);
  }
  if (estimate.room_rt60) json["room_rt60_s"] = *estimate.room_rt60;
  if (estimate.damping) {
    json["model"] = synth::damping::formula_of(estimate.damping->model);
    json["parameters"] =
        damping::alphas_json(estimate.damping->model, estimate.damping->confidence95);
  }
  for (const MatchedTone& match : estimate.matches) json["matches"].push_back(json_of(match));
  for (const auto& [stage, entry] : trace.stages) {
    json["timing"][stage + "_s"] = entry.seconds;
    json["calls"][stage] = entry.calls;
  }
  return json;
}

void print_estimate(const PitchEstimate& estimate, const std::optional<double>& density,
                    const core::Trace& trace) {
  if (!estimate.specific_modulus) {
    fmt::print("the material is not determined\n- {}\n", estimate.undetermined);
  } else {
    const double modulus = *estimate.specific_modulus;
    const core::Range& range = estimate.modulus95;
    fmt::print("{:<22} {:.5g} m^2/s^2, 95 %: {:.5g} to {:.5g}\n", "specific modulus", modulus,
               range.low, range.high);
    if (density) {
      const double giga = 1e-9 * *density;
      fmt::print("{:<22} {:.5g} GPa at {:.5g} kg/m^3, 95 %: {:.5g} to {:.5g}\n", "Young's modulus",
                 giga * modulus, *density, giga * range.low, giga * range.high);
    }
    fmt::print("{:<22} {:.5g} of the assumed material's, 95 %: {:.5g} to {:.5g}\n",
               "frequency scale", *estimate.frequency_scale, estimate.scale95.low,
               estimate.scale95.high);
    if (estimate.poisson_ratio) {
      fmt::print("{:<22} {:.3g}, 95 %: {:.3g} to {:.3g}\n", "Poisson's ratio",
                 *estimate.poisson_ratio, estimate.poisson95.low, estimate.poisson95.high);
    }
    fmt::print("{:<22} {} of {} tones are modes', which scatter by {:.3g} cents\n", "pitches",
               estimate.matches.size(), estimate.tones, estimate.scatter_cents);
  }
  if (estimate.damping) {
    const synth::damping::DampingModel& model = estimate.damping->model;
    fmt::print("{:<22} {}\n", "damping",
               model.kind == synth::damping::DampingKind::expression
                   ? "c = " + model.expression
                   : synth::damping::form_of(model.kind).formula);
    for (std::size_t k = 0; k < model.parameters.size(); ++k) {
      fmt::print("  {:<20} {:.5g} {}, {}\n", synth::damping::parameter_name(k), model.parameters[k],
                 synth::damping::parameter_unit(model.kind, k),
                 damping::interval_text(estimate.damping->confidence95[k]));
    }
  }
  for (const std::string& remark : estimate.remarks) fmt::print("- {}\n", remark);
  for (const auto& [stage, entry] : trace.stages) {
    fmt::print("{:<22} {:8.3f} s\n", stage, entry.seconds);
  }
}

}  // namespace carillon::eval::material
