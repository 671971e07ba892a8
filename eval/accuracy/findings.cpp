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
                                    std::span<const double> reference, std::size_t most) {
  std::vector<double> errors;
  const std::size_t count = std::min({frequencies.size(), reference.size(), most});
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

double time_of(const AccuracyConfig& config, const RefinementLevel& level) {
  return config.cpu_time ? level.cpu_seconds : level.seconds;
}

json level_json(const AccuracyConfig& config, const RefinementLevel& level,
                const Reference& reference) {
  json out = {{"order", level.options.order},
              {"element_size_m", nullptr},
              {"automatic_size", level.options.element_size <= 0},
              {"size_factor", nullptr},
              {"tolerance", level.tolerance}};
  if (std::isfinite(level.element_size)) out["element_size_m"] = level.element_size;
  if (level.size_factor > 0) out["size_factor"] = level.size_factor;
  if (!level.failure.empty()) out["failure"] = level.failure;
  if (level.error) return out;
  out["elements"] = level.mesh.mesh.element_count();
  out["unknowns"] = level.modes.certificate.unknowns;
  out["seconds"] = time_of(config, level);
  out["wall_seconds"] = level.seconds;
  out["processor_seconds"] = level.cpu_seconds;
  out["runs"] = level.runs;
  for (const auto& [stage, seconds] : level.stages) out["stages"][stage + "_s"] = seconds;
  const std::size_t first = reference.first, count = reference.compared();
  const auto frequencies = frequencies_of(level.modes, first, count);
  out["modes"] = frequencies.size();
  out["frequencies_hz"] = frequencies;
  // Ranks without a partner say nothing of the others' errors.
  if (!level.failure.empty()) return out;
  const auto errors =
      errors_in_cents(frequencies, std::span(reference.frequencies).subspan(first), count);
  out["errors_cents"] = errors;
  const Summary truth = summary(errors);
  out["worst_cents"] = truth.worst;
  out["median_cents"] = core::number_or_null(truth.median);
  out["estimated_worst_cents"] = nullptr;
  out["estimated_median_cents"] = nullptr;
  out["estimated_errors_cents"] = json::array();
  if (!level.modes.pitch_errors.empty()) {
    const auto from = level.modes.pitch_errors.begin() + static_cast<std::ptrdiff_t>(first);
    const std::vector<double> estimates(from, from + static_cast<std::ptrdiff_t>(count));
    const Summary estimate = summary(estimates);
    out["estimated_errors_cents"] = estimates;
    out["estimated_worst_cents"] = estimate.worst;
    out["estimated_median_cents"] = core::number_or_null(estimate.median);
  }
  return out;
}

json choice_json(const AccuracyConfig& config, const Choice& choice,
                 const std::vector<const RefinementLevel*>& levels) {
  json out = {{"asked_cents", choice.cents}, {"met", false}};
  if (!choice.failure.empty()) {
    out["failure"] = choice.failure;
  } else {
    out = solvers::pitch::to_json(choice.report, false);
  }
  out["command"] = choice.command.empty() ? json() : json(choice.command);
  if (!choice.failure.empty()) return out;
  double all = 0;
  for (std::size_t i = 0; i < choice.steps.size(); ++i) {
    const double seconds = time_of(config, *choice.steps[i]);
    all += seconds;
    out["steps"][i]["seconds"] = seconds;
  }
  const RefinementLevel* chosen = choice.steps.at(choice.report.chosen);
  out["seconds"] = time_of(config, *chosen);
  out["search_seconds"] = all;
  out["level"] = std::find(levels.begin(), levels.end(), chosen) - levels.begin();
  return out;
}

std::string number(const json& value, double factor = 1) {
  return value.is_null() ? "-" : fmt::format("{:.3g}", factor * value.get<double>());
}

}  // namespace

json to_json(const AccuracyConfig& config, const Findings& findings) {
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
  std::vector<CostPoint> points;
  std::vector<std::size_t> place;  // of each point among the levels
  out["levels"] = json::array();
  for (const RefinementLevel* level : findings.levels) {
    json entry = level_json(config, *level, reference);
    entry["on_front"] = false;
    if (level->failure.empty()) {
      points.push_back({entry.at("seconds"), entry.at("worst_cents")});
      place.push_back(out["levels"].size());
    }
    out["levels"].push_back(std::move(entry));
  }
  std::vector<CostPoint> front;
  out["front"] = json::array();
  for (const std::size_t i : pareto_front(points)) {
    front.push_back(points[i]);
    out["front"].push_back(place[i]);
    out["levels"][place[i]]["on_front"] = true;
  }
  out["half_the_error_costs"] = nullptr;
  if (const auto factor = cost_of_half_the_error(front)) out["half_the_error_costs"] = *factor;
  out["chosen"] = json::array();
  for (const Choice& choice : findings.choices)
    out["chosen"].push_back(choice_json(config, choice, findings.levels));
  return out;
}

bool has_failed(const json& object) {
  if (object.contains("failure")) return !object.at("passed_over").get<bool>();
  const json& chosen = object.at("chosen");
  return std::any_of(chosen.begin(), chosen.end(),
                     [](const json& choice) { return choice.contains("failure"); });
}

namespace {

void print_level(const json& level) {
  fmt::print("{:>5} {:>10} {:>9.0e} ", level.at("order").get<int>(),
             number(level.at("element_size_m"), 1e3), level.at("tolerance").get<double>());
  if (level.contains("elements")) {
    fmt::print("{:>9} {:>9} {:>9.2f} ", level.at("elements").get<std::int64_t>(),
               level.at("unknowns").get<std::int64_t>(), level.at("seconds").get<double>());
  }
  if (level.contains("failure")) {
    fmt::print("{}\n", level.at("failure").get<std::string>());
    return;
  }
  fmt::print("| {:>9} {:>9} | {:>9} {:>9} {}\n", number(level["worst_cents"]),
             number(level["estimated_worst_cents"]), number(level["median_cents"]),
             number(level["estimated_median_cents"]), level.at("on_front") ? "front" : "");
}

void print_choice(const json& choice, const json& levels) {
  fmt::print("--pitch-cents {:<4} ", number(choice["asked_cents"]));
  if (choice.contains("failure")) {
    fmt::print("failed: {}\n", choice.at("failure").get<std::string>());
    return;
  }
  const json& level = levels.at(choice.at("level").get<std::size_t>());
  const bool met = choice.at("met");
  fmt::print("{}: order {}, {} mm, {:.2f} s ({:.2f} s with the steps to it), {}{}\n",
             met ? "met" : "not met", level.at("order").get<int>(),
             number(level.at("element_size_m"), 1e3), choice.at("seconds").get<double>(),
             choice.at("search_seconds").get<double>(),
             level.contains("failure")
                 ? level.at("failure").get<std::string>()
                 : fmt::format("worst {} cents", number(level["worst_cents"])),
             met ? "" : "; " + choice.at("reason").get<std::string>());
}

}  // namespace

void print_findings(const json& object) {
  fmt::print("\n{}", object.at("name").get<std::string>());
  if (object.contains("note")) fmt::print(" ({})", object.at("note").get<std::string>());
  if (object.contains("failure")) {
    fmt::print(": {}", object.at("failure").get<std::string>());
  }
  if (!object.contains("reference")) {
    fmt::print("\n");
    return;
  }
  const json& reference = object.at("reference");
  const json& frequencies = reference.at("frequencies_hz");
  fmt::print(
      ": {} modes from {:.5g} to {:.5g} Hz against a reference by {}, itself within {} cents "
      "by its estimate\n",
      frequencies.size(), frequencies.front().get<double>(), frequencies.back().get<double>(),
      reference.at("solver").get<std::string>(), number(reference["estimated_worst_cents"]));
  fmt::print("{:>5} {:>10} {:>9} {:>9} {:>9} {:>9} | {:>9} {:>9} | {:>9} {:>9}\n", "order",
             "size [mm]", "tolerance", "elements", "unknowns", "time [s]", "worst", "estimate",
             "median", "estimate");
  for (const json& level : object.at("levels")) print_level(level);
  for (const json& choice : object.at("chosen")) print_choice(choice, object.at("levels"));
  if (!object.at("half_the_error_costs").is_null()) {
    fmt::print("half the error costs {:.2f} times the time\n",
               object.at("half_the_error_costs").get<double>());
  }
}

}  // namespace carillon::eval::accuracy
