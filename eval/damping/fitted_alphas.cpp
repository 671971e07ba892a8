#include "eval/damping/fitted_alphas.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/json.hpp"
#include "core/numbers.hpp"

namespace carillon::eval::damping {

using nlohmann::json;

json alphas_json(const synth::damping::DampingModel& model,
                 std::span<const core::Range> confidence95) {
  json alphas = json::object();
  json confidence = json::object();
  for (std::size_t k = 0; k < model.parameters.size(); ++k) {
    const std::string name = synth::damping::parameter_name(k);
    alphas[name] = model.parameters[k];
    if (confidence95.empty()) continue;
    confidence[name] = {core::number_or_null(confidence95[k].low),
                        core::number_or_null(confidence95[k].high)};
  }
  if (!confidence.empty()) alphas["confidence95"] = confidence;
  return alphas;
}

std::string interval_text(const core::Range& interval) {
  const auto end = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.5g}", value) : std::string("any");
  };
  return fmt::format("95 %: {} to {}", end(interval.low), end(interval.high));
}

}  // namespace carillon::eval::damping
