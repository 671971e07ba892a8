#include "eval/accuracy/findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/json.hpp"
#include "core/numbers.hpp"

namespace carillon::eval::accuracy {

using nlohmann::json;

std::vector<double> errors_in_cents(std::span<const double> frequencies,
                                    std::span<const double> reference, std::size_t maximum) {
  std::vector<double> errors;
  const std::size_t count = std::min({frequencies.size(), reference.size(), maximum});
  for (std::size_t k = 0; k < count; ++k)
    errors.push_back(core::cents(frequencies[k] / reference[k]));
  return errors;
}

/// Errors that differ by less are those of the same mesh at another tolerance of the solver.
constexpr double same_error = 1e-3;

std::vector<std::size_t> pareto_front(std::span<const CostPoint> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a].seconds != points[b].seconds ? points[a].seconds < points[b].seconds
                                                  : points[a].cents < points[b].cents;
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order)
    if (front.empty() || points[i].cents < (1 - same_error) * points[front.back()].cents) {
      front.push_back(i);
    }
  return front;
}

std::optional<double> cost_of_half_the_error(std::span<const CostPoint> front) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const CostPoint& point : front) {
    if (!(point.cents > 0) || !(point.seconds > 0)) continue;
    const double error = std::log(point.cents), time = std::log(point.seconds);
    n += 1;
    x += error;
    y += time;
    xx += error * error;
    xy += error * time;
  }
  const double spread = n * xx - x * x;
  // Errors that do not differ by more than rounding have no slope.
  if (n < 3 || spread <= 1e-9 * n * n) return std::nullopt;
  const double slope = (n * xy - x * y) / spread;  // negative: less error, more time
  return std::exp2(-slope);
}

namespace {

struct Summary {
  double worst = 0, median = 0;
};

Summary summary(std::vector<double> errors) {
  for (double& e : errors) e = std::abs(e);
  Summary out;
  if (!errors.empty()) out.worst = *std::max_element(errors.begin(), errors.end());
  out.median = core::median(errors);
  return out;
}

/// Frequencies of a set from the k-th, `count` or as many as there are.
std::vector<double> frequencies_of(const solvers::modes::Modes& modes, std::size_t k,
                                   std::size_t count) {
  std::vector<double> out;
  for (; k < modes.size() && out.size() < count; ++k) out.push_back(modes.frequency(k));
  return out;
}

json level_json(const ComparedRung& level) {
  json out = {{"order", level.order},
              {"element_size_m", core::number_or_null(level.element_size)},
              {"automatic_size", level.automatic_size},
              {"size_factor", nullptr},
              {"tolerance", level.tolerance},
              {"on_front", false}};
  if (level.size_factor > 0) out["size_factor"] = level.size_factor;
  if (!level.failure.empty()) out["failure"] = level.failure;
  if (!level.has_modes) return out;
  out["elements"] = level.elements;
  out["unknowns"] = level.unknowns;
  out["seconds"] = level.seconds;
  out["wall_seconds"] = level.wall_seconds;
  out["processor_seconds"] = level.processor_seconds;
  out["runs"] = level.runs;
  for (const auto& [stage, seconds] : level.stages) out["stages"][stage + "_s"] = seconds;
  out["modes"] = level.frequencies.size();
  out["frequencies_hz"] = level.frequencies;
  if (!level.failure.empty()) return out;
  const Summary truth = summary(level.errors), estimate = summary(level.estimates);
  out["errors_cents"] = level.errors;
  out["worst_cents"] = truth.worst;
  out["median_cents"] = core::number_or_null(truth.median);
  out["estimated_errors_cents"] = level.estimates;
  out["estimated_worst_cents"] = level.estimates.empty() ? json() : json(estimate.worst);
  out["estimated_median_cents"] = core::number_or_null(estimate.median);
  return out;
}

/// What a choice cost: its own level [s], and all steps to it.
struct ChoiceCost {
  double seconds = 0, search_seconds = 0;
};

ChoiceCost cost_of(const Choice& choice, const std::vector<ComparedRung>& levels) {
  ChoiceCost cost{levels[choice.steps.at(choice.report.chosen)].seconds, 0};
  for (const std::size_t step : choice.steps) cost.search_seconds += levels[step].seconds;
  return cost;
}

json choice_json(const Choice& choice, const std::vector<ComparedRung>& levels) {
  const json command = choice.command.empty() ? json() : json(choice.command);
  if (!choice.failure.empty()) {
    return {{"asked_cents", choice.cents},
            {"met", false},
            {"failure", choice.failure},
            {"command", command}};
  }
  json out = solvers::pitch::to_json(choice.report, false);
  out["command"] = command;
  for (std::size_t i = 0; i < choice.steps.size(); ++i) {
    out["steps"][i]["seconds"] = levels[choice.steps[i]].seconds;
  }
  const ChoiceCost cost = cost_of(choice, levels);
  out["seconds"] = cost.seconds;
  out["search_seconds"] = cost.search_seconds;
  out["level"] = choice.steps[choice.report.chosen];
  return out;
}

/// Levels that no other beats.
struct Front {
  std::vector<std::size_t> levels;
  std::optional<double> half_the_error_costs;
};

Front front_of(const std::vector<ComparedRung>& levels) {
  std::vector<CostPoint> points, best;
  std::vector<std::size_t> place;  // of each point among the levels
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (!levels[i].failure.empty()) continue;
    points.push_back({levels[i].seconds, summary(levels[i].errors).worst});
    place.push_back(i);
  }
  Front front;
  for (const std::size_t i : pareto_front(points)) {
    best.push_back(points[i]);
    front.levels.push_back(place[i]);
  }
  front.half_the_error_costs = cost_of_half_the_error(best);
  return front;
}

std::string number(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g}", value) : "-";
}

}  // namespace

ComparedRung compare(const AccuracyConfig& config, const RefinementLevel& level,
                     const Reference& reference) {
  ComparedRung out;
  out.order = level.options.order;
  out.element_size = level.element_size;
  out.automatic_size = level.options.element_size <= 0;
  out.size_factor = level.size_factor;
  out.tolerance = level.tolerance;
  out.failure = level.failure;
  out.has_modes = !level.error;
  if (level.error) return out;
  out.elements = static_cast<std::int64_t>(level.mesh.mesh.element_count());
  out.unknowns = level.modes.certificate.unknowns;
  out.seconds = config.cpu_time ? level.cpu_seconds : level.seconds;
  out.wall_seconds = level.seconds;
  out.processor_seconds = level.cpu_seconds;
  out.runs = level.runs;
  out.stages = level.stages;
  const std::size_t first = reference.first, count = reference.compared();
  out.frequencies = frequencies_of(level.modes, first, count);
  // Ranks without a partner say nothing of the others' errors.
  if (!level.failure.empty()) return out;
  out.errors =
      errors_in_cents(out.frequencies, std::span(reference.frequencies).subspan(first), count);
  if (!level.modes.pitch_errors.empty()) {
    const auto from = level.modes.pitch_errors.begin() + static_cast<std::ptrdiff_t>(first);
    out.estimates.assign(from, from + static_cast<std::ptrdiff_t>(count));
  }
  return out;
}

json to_json(const Findings& findings) {
  json out = {{"name", findings.name}};
  if (!findings.note.empty()) out["note"] = findings.note;
  if (!findings.failure.empty()) {
    out["failure"] = findings.failure;
    out["passed_over"] = findings.passed_over;
  }
  const Reference& reference = findings.reference;
  if (reference.frequencies.empty()) return out;
  out["reference"] = {
      {"solver", reference.solver},
      {"unknowns", reference.unknowns},
      {"seconds", reference.seconds},
      {"estimated_worst_cents", reference.worst_cents},
      {"modes", reference.compared()},
      {"first_mode", reference.first + 1},
      {"frequencies_hz",
       std::vector(reference.frequencies.begin() + static_cast<std::ptrdiff_t>(reference.first),
                   reference.frequencies.end())}};
  if (reference.order > 0) {
    out["reference"]["order"] = reference.order;
    out["reference"]["element_size_m"] = reference.element_size;
  }
  out["levels"] = json::array();
  for (const ComparedRung& level : findings.levels) out["levels"].push_back(level_json(level));
  const Front front = front_of(findings.levels);
  out["front"] = front.levels;
  for (const std::size_t i : front.levels) out["levels"][i]["on_front"] = true;
  out["half_the_error_costs"] = nullptr;
  if (front.half_the_error_costs) out["half_the_error_costs"] = *front.half_the_error_costs;
  out["chosen"] = json::array();
  for (const Choice& choice : findings.choices) {
    out["chosen"].push_back(choice_json(choice, findings.levels));
  }
  return out;
}

bool has_failed(const Findings& findings) {
  if (!findings.failure.empty()) return !findings.passed_over;
  return std::any_of(findings.choices.begin(), findings.choices.end(),
                     [](const Choice& choice) { return !choice.failure.empty(); });
}

namespace {

void print_level(const ComparedRung& level, bool on_front) {
  fmt::print("{:>5} {:>10} {:>9.0e} ", level.order, number(1e3 * level.element_size),
             level.tolerance);
  if (level.has_modes) {
    fmt::print("{:>9} {:>9} {:>9.2f} ", level.elements, level.unknowns, level.seconds);
  }
  if (!level.failure.empty()) {
    fmt::print("{}\n", level.failure);
    return;
  }
  const Summary truth = summary(level.errors), estimate = summary(level.estimates);
  fmt::print("| {:>9} {:>9} | {:>9} {:>9} {}\n", number(truth.worst),
             level.estimates.empty() ? "-" : number(estimate.worst), number(truth.median),
             number(estimate.median), on_front ? "front" : "");
}

void print_choice(const Choice& choice, const std::vector<ComparedRung>& levels) {
  fmt::print("--pitch-cents {:<4} ", number(choice.cents));
  if (!choice.failure.empty()) {
    fmt::print("failed: {}\n", choice.failure);
    return;
  }
  const ComparedRung& level = levels[choice.steps.at(choice.report.chosen)];
  const ChoiceCost cost = cost_of(choice, levels);
  const bool met = choice.report.met();
  fmt::print("{}: order {}, {} mm, {:.2f} s ({:.2f} s with the steps to it), {}{}\n",
             met ? "met" : "not met", level.order, number(1e3 * level.element_size), cost.seconds,
             cost.search_seconds,
             level.failure.empty()
                 ? fmt::format("worst {} cents", number(summary(level.errors).worst))
                 : level.failure,
             met ? "" : "; " + choice.report.reason);
}

}  // namespace

void print(const Findings& findings) {
  fmt::print("\n{}", findings.name);
  if (!findings.note.empty()) fmt::print(" ({})", findings.note);
  if (!findings.failure.empty()) fmt::print(": {}", findings.failure);
  const Reference& reference = findings.reference;
  if (reference.frequencies.empty()) {
    fmt::print("\n");
    return;
  }
  fmt::print(
      ": {} modes from {:.5g} to {:.5g} Hz against a reference by {}, itself within {} cents "
      "by its estimate\n",
      reference.compared(), reference.frequencies[reference.first], reference.frequencies.back(),
      reference.solver, number(reference.worst_cents));
  fmt::print("{:>5} {:>10} {:>9} {:>9} {:>9} {:>9} | {:>9} {:>9} | {:>9} {:>9}\n", "order",
             "size [mm]", "tolerance", "elements", "unknowns", "time [s]", "worst", "estimate",
             "median", "estimate");
  const Front front = front_of(findings.levels);
  for (std::size_t i = 0; i < findings.levels.size(); ++i) {
    print_level(findings.levels[i],
                std::find(front.levels.begin(), front.levels.end(), i) != front.levels.end());
  }
  for (const Choice& choice : findings.choices) print_choice(choice, findings.levels);
  if (front.half_the_error_costs) {
    fmt::print("half the error costs {:.2f} times the time\n", *front.half_the_error_costs);
  }
}

}  // namespace carillon::eval::accuracy
