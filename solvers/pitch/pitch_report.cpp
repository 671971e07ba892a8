#include "solvers/pitch/pitch_report.hpp"

#include <nlohmann/json.hpp>

#include "core/json.hpp"

namespace carillon::solvers::pitch {

nlohmann::json to_json(const PitchReport& report, bool with_seconds) {
  nlohmann::json steps = nlohmann::json::array();
  for (const PitchStep& step : report.steps) {
    steps.push_back({{"order", step.order},
                     {"element_size_m", step.element_size},
                     {"automatic_size", step.automatic_size},
                     {"edge_layers", step.edge_layers},
                     {"elements", step.elements},
                     {"unknowns", step.unknowns},
                     {"worst_cents", step.worst_cents},
                     {"median_cents", core::number_or_null(step.median_cents)}});
    if (with_seconds) steps.back()["seconds"] = step.seconds;
  }
  nlohmann::json out = {{"asked_cents", report.asked_cents},
                        {"reached_cents", report.reached_cents},
                        {"met", report.met()},
                        {"chosen", report.chosen},
                        {"steps", steps},
                        {"stopped_by", nullptr},
                        {"reason", nullptr}};
  if (!report.met()) {
    out["stopped_by"] = report.stopped_by;
    out["reason"] = report.reason;
  }
  return out;
}

}  // namespace carillon::solvers::pitch
