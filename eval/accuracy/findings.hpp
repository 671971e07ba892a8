#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/accuracy/refinement_levels.hpp"

namespace carillon::eval::accuracy {

/// Distances of a set's pitches to a reference's [cent], the k-th to the k-th: by the min-max
/// principle the k-th eigenvalue of conforming elements bounds the k-th of the object that they
/// fill from above, and of all ways to pair two sets that of equal ranks has the least total
/// distance. Modes that cross therefore count with the distance of their ranks.
/// @param maximum  so many at most are compared
std::vector<double> errors_in_cents(std::span<const double> frequencies,
                                    std::span<const double> reference, std::size_t maximum);

/// A level as the front sees it.
struct CostPoint {
  double seconds = 0;
  double cents = 0;  ///< worst true error
};

/// Points that no other beats in time and error both, by rising seconds. Errors within 0.1 % are
/// the same.
/// @return indices into `points`
std::vector<std::size_t> pareto_front(std::span<const CostPoint> points);

/// By how much half the error multiplies the time, from the slope of the front in logarithms, by
/// least squares. Nothing when there are fewer than three points.
std::optional<double> cost_of_half_the_error(std::span<const CostPoint> front);

/// A level held against the reference.
struct ComparedRung {
  int order = 0;
  double element_size = 0;  ///< [m]; NaN where it cannot be known
  bool automatic_size = false;
  double size_factor = 0;  ///< on the automatic size; 0: asked for by a target
  double tolerance = 0;
  std::string failure;     ///< why it cannot be compared, else ""
  bool has_modes = false;  ///< what follows is known
  std::int64_t elements = 0, unknowns = 0;
  double seconds = 0;  ///< by the configuration's clock
  double wall_seconds = 0, processor_seconds = 0;
  int runs = 0;
  std::map<std::string, double> stages;  ///< [s]
  std::vector<double> frequencies;       ///< [Hz] of the modes that are compared
  /// Of each mode its error, and the estimate of it [cent]; none of a level that failed.
  std::vector<double> errors, estimates;
};

/// @param reference  with frequencies
ComparedRung compare(const AccuracyConfig& config, const RefinementLevel& level,
                     const Reference& reference);

/// One setting that --pitch-cents chose.
struct Choice {
  double cents = 0;
  std::string command;  ///< that chooses the same; "": there is none
  std::string failure;  ///< why nothing was chosen, else ""
  solvers::pitch::PitchReport report;
  std::vector<std::size_t> steps;  ///< levels of the report's steps
};

/// What was found for one object.
struct Findings {
  std::string name;
  std::string note;          ///< a stand-in was used, for instance
  std::string failure;       ///< what ended the measurements, else ""
  bool passed_over = false;  ///< an optional file is missing: nothing failed
  Reference reference;
  std::vector<ComparedRung> levels;  ///< none without frequencies of the reference
  std::vector<Choice> choices;
};

/// The schema is in docs/accuracy.md.
nlohmann::json to_json(const Findings& findings);

/// Whether an object, or one of its targets, could not be had. A target that is not met, a level
/// that fails and an optional file that is missing are findings like any other.
bool has_failed(const Findings& findings);

/// Tables for a person.
void print(const Findings& findings);

}  // namespace carillon::eval::accuracy
