#include "eval/material/joint_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/material/detail/coordinates.hpp"
#include "eval/material/detail/judge_estimate.hpp"
#include "eval/material/detail/minimise.hpp"

namespace carillon::eval::material {

namespace {

/// Minima that a search begins from.
constexpr std::size_t searches = 4;
/// Logarithms of specific moduli nearer than this lead to the same minimum.
constexpr double same_modulus = 0.01;
constexpr double tolerance = 1e-7;
constexpr int max_evaluations = 800;

/// Every recording that has an estimate of its own, ready to be compared with candidates.
struct Recordings {
  std::vector<Reference> references;
  std::vector<Objective> objectives;

  double mean(const Candidate& candidate) const {
    double sum = 0;
    for (const Objective& objective : objectives) sum += objective.value_of(candidate).metric;
    return sum / static_cast<double>(objectives.size());
  }
  double mean(std::span<const double> x) const {
    double sum = 0;
    for (const Objective& objective : objectives) sum += objective.metric(x);
    return sum / static_cast<double>(objectives.size());
  }
};

void estimate_each(std::span<const StruckRecording> recordings, const MaterialOptions& options,
                   JointEstimate& estimate) {
  std::string why = "there are no recordings";
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const StruckRecording& recording = recordings[i];
    estimate.alone.emplace_back();
    try {
      estimate.alone.back() =
          estimate_material(recording.samples, *recording.set, recording.modes, options);
    } catch (const core::InputError& error) {
      why = error.message();
      estimate.remarks.push_back(fmt::format("recording {} is left out: {}", i + 1, why));
    }
  }
  const auto there = [](const auto& alone) { return alone.has_value(); };
  if (std::none_of(estimate.alone.begin(), estimate.alone.end(), there)) {
    throw core::InputError("no recording that a material can be estimated from: " + why);
  }
}

Recordings prepare(std::span<const StruckRecording> recordings, const MaterialOptions& options,
                   const Coordinates& coordinates, const JointEstimate& estimate) {
  Recordings all;
  // Objectives refer to their references, which must not move.
  all.references.reserve(recordings.size());
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    if (!estimate.alone[i]) continue;
    const StruckRecording& recording = recordings[i];
    all.references.push_back(make_reference(recording.samples, *recording.set, options.metric));
    all.objectives.push_back(
        {all.references.back(), recording.modes, options.motion, coordinates, options.starts});
  }
  return all;
}

Coordinates coordinates_of(std::span<const StruckRecording> recordings,
                           const MaterialOptions& options, const JointEstimate& estimate) {
  damping::DampingData data;
  const Candidate* first = nullptr;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    if (!estimate.alone[i]) continue;
    if (first == nullptr) first = &estimate.alone[i]->candidate;
    const damping::DampingData more = damping::damping_data(recordings[i].set->features);
    data.eigenvalues.insert(data.eigenvalues.end(), more.eigenvalues.begin(),
                            more.eigenvalues.end());
    data.coefficients.insert(data.coefficients.end(), more.coefficients.begin(),
                             more.coefficients.end());
  }
  Coordinates coordinates = make_coordinates(
      options.law, first->damping, core::median(data.eigenvalues), core::median(data.coefficients));
  coordinates.contact_sought = !options.contact_time.has_value();
  coordinates.contact_time = options.contact_time.value_or(first->contact_time);
  return coordinates;
}

/// Where the searches begin: minima of single recordings with moduli of their own, best first.
std::vector<Candidate> starts(const JointEstimate& estimate, const Recordings& all) {
  std::vector<std::pair<double, Candidate>> sorted;
  for (const auto& alone : estimate.alone) {
    if (!alone) continue;
    for (const LocalMinimum& minimum : alone->minima) {
      sorted.emplace_back(all.mean(minimum.candidate), minimum.candidate);
    }
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Candidate> kept;
  for (const auto& entry : sorted) {
    const auto& candidate = entry.second;
    if (kept.size() == searches) break;
    const bool again = std::any_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      return std::abs(std::log(other.specific_modulus / candidate.specific_modulus)) < same_modulus;
    });
    if (!again) kept.push_back(candidate);
  }
  return kept;
}

}  // namespace

JointEstimate estimate_jointly(std::span<const StruckRecording> recordings,
                               const MaterialOptions& options) {
  JointEstimate estimate;
  estimate_each(recordings, options, estimate);
  const Coordinates coordinates = coordinates_of(recordings, options, estimate);
  const Recordings all = prepare(recordings, options, coordinates, estimate);
  bool found_one = false;
  for (const Candidate& start : starts(estimate, all)) {
    const Minimum found = minimise([&](std::span<const double> x) { return all.mean(x); },
                                   to_coordinates(coordinates, start), first_steps(coordinates),
                                   tolerance, max_evaluations);
    estimate.evaluations += static_cast<std::size_t>(found.evaluations) * all.objectives.size();
    if (found_one && !(found.value < estimate.metric)) continue;
    found_one = true;
    estimate.metric = found.value;
    estimate.candidate = from_coordinates(coordinates, found.x);
  }
  return estimate;
}

}  // namespace carillon::eval::material
