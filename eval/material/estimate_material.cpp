#include "eval/material/estimate_material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/material/detail/coordinates.hpp"
#include "eval/material/detail/judge_estimate.hpp"
#include "eval/material/detail/minimise.hpp"

namespace carillon::eval::material {

namespace {

/// Taken where a contact time is sought [s].
constexpr double usual_contact = 2e-4;
/// Starts that are ranked by the whole metric.
constexpr std::size_t ranked_count = 96;
/// Logarithms of specific moduli nearer than this lead to the same minimum.
constexpr double same_basin = 0.01;
/// Times what the spectrograms differ by at the minimum: differences below weigh little.
constexpr double unexplained = 4;
constexpr double roughly = 1e-3;
constexpr double finely = 1e-8;
constexpr int rough_evaluations = 200;
constexpr int fine_evaluations = 1500;

bool near(const Candidate& a, const Candidate& b, double distance) {
  return std::abs(std::log(a.specific_modulus / b.specific_modulus)) < distance;
}

void check(const StruckModes& modes) {
  if (modes.eigenvalues.empty()) {
    throw core::InputError("the assumed object has no mode in its band",
                           "raise --max-frequency, or check the object's size");
  }
  const auto heard = [](double gain) { return gain != 0; };
  if (std::none_of(modes.gains.begin(), modes.gains.end(), heard)) {
    throw core::InputError("a strike at this point and in this direction rings no mode there",
                           "check --at and --direction");
  }
}

/// The best starts by the whole metric, each of them once: same modulus and damping model.
std::vector<LocalMinimum> ranked(const std::vector<Start>& starts, const Objective& objective) {
  std::vector<const Start*> kept;
  for (const Start& start : starts) {
    if (kept.size() == ranked_count) break;
    const bool again = std::any_of(kept.begin(), kept.end(), [&](const Start* other) {
      return other->sample == start.sample && near(other->candidate, start.candidate, 0.002);
    });
    if (!again) kept.push_back(&start);
  }
  std::vector<LocalMinimum> best;
  for (const Start* start : kept) {
    best.push_back({start->candidate, objective.value_of(start->candidate)});
  }
  std::stable_sort(best.begin(), best.end(), [](const LocalMinimum& a, const LocalMinimum& b) {
    return a.value.metric < b.value.metric;
  });
  return best;
}

/// The first of each basin, at most `maximum`.
std::vector<LocalMinimum> apart(const std::vector<LocalMinimum>& sorted, std::size_t maximum) {
  std::vector<LocalMinimum> kept;
  for (const LocalMinimum& minimum : sorted) {
    if (kept.size() == maximum) break;
    const bool again = std::any_of(kept.begin(), kept.end(), [&](const LocalMinimum& other) {
      return near(other.candidate, minimum.candidate, same_basin);
    });
    if (!again) kept.push_back(minimum);
  }
  return kept;
}

void sort_by_metric(std::vector<LocalMinimum>& minima) {
  std::stable_sort(minima.begin(), minima.end(), [](const LocalMinimum& a, const LocalMinimum& b) {
    return a.value.metric < b.value.metric;
  });
}

}  // namespace

MaterialEstimate estimate_material(std::span<const double> samples, const features::FeatureSet& set,
                                   const StruckModes& modes, const MaterialOptions& options) {
  check(modes);
  const Reference reference = make_reference(samples, set, options.metric);
  const auto damping =
      damping_starts(set.features, options.law, reference.options.match, options.starts);
  const double contact = options.contact_time.value_or(usual_contact);
  const std::vector<Start> starts = start_points(set.features, modes, damping, contact,
                                                 options.motion, reference, options.starts);
  if (starts.empty()) {
    throw core::InputError(
        fmt::format("no specific modulus between {:.3g} and {:.3g} m^2/s^2 makes a mode of the "
                    "assumed object sound like a feature",
                    options.starts.min_modulus, options.starts.max_modulus),
        "check the object's size, and whether the recording is of this object");
  }

  const damping::DampingData data = damping::damping_data(set.features);
  Coordinates coordinates =
      make_coordinates(options.law, damping.front(), core::median(data.eigenvalues),
                       core::median(data.coefficients));
  coordinates.contact_sought = !options.contact_time.has_value();
  coordinates.contact_time = contact;
  Objective objective{reference, modes, options.motion, coordinates, options.starts};

  MaterialEstimate estimate;
  estimate.starts = starts.size();
  const auto search = [&](const Objective& goal, const LocalMinimum& from, double tolerance,
                          int maximum) {
    const auto found = minimise([&](std::span<const double> x) { return goal.metric(x); },
                                to_coordinates(coordinates, from.candidate),
                                first_steps(coordinates), tolerance, maximum);
    estimate.evaluations += static_cast<std::size_t>(found.evaluations);
    estimate.converged = found.converged;
    const Candidate candidate = from_coordinates(coordinates, found.x);
    const MetricValue value = goal.value_of(candidate);
    // A start on the edge of what is allowed may be better than where its coordinates lead.
    return value.metric <= from.value.metric ? LocalMinimum{candidate, value} : from;
  };
  std::vector<LocalMinimum> minima;
  for (const LocalMinimum& start : apart(ranked(starts, objective), options.searches)) {
    minima.push_back(search(objective, start, roughly, rough_evaluations));
  }
  sort_by_metric(minima);
  minima = apart(minima, minima.size());
  // Two searches, as the second begins with large steps where the first ended with small ones. What
  // the spectrograms still differ by then, no candidate explains.
  Reference settled = reference;
  const Objective finish{settled, modes, options.motion, coordinates, options.starts};
  for (int again = 0; again < 2; ++again) {
    double& minimum = settled.options.min_difference;
    if (minimum > 0) minimum = std::max(minimum, unexplained * minima.front().value.psychoacoustic);
    minima.front().value = finish.value_of(minima.front().candidate);
    minima.front() = search(finish, minima.front(), finely, fine_evaluations);
  }
  // All minima by one measure.
  minima.front().value = objective.value_of(minima.front().candidate);
  estimate.minima = minima;
  estimate.candidate = minima.front().candidate;
  estimate.value = minima.front().value;
  judge(estimate, set.features, finish);
  return estimate;
}

}  // namespace carillon::eval::material
