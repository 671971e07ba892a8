#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace carillon::solvers::pitch {

/// One setting that was tried.
struct PitchStep {
  int order = 0;
  double element_size = 0;  ///< as asked for [m]; the longest edge where it was automatic
  bool automatic_size = false;
  int edge_layers = 0;  ///< asked for
  std::int64_t elements = 0;
  std::int64_t unknowns = 0;
  double seconds = 0;  ///< mesh and solve; short when they came from a cache
  /// Estimated error of the worst mode. 0 when there is no mode, which two settings have to show;
  /// the first one counts as far off.
  double worst_cents = 0;
  double median_cents = 0;  ///< NaN of none
};

struct PitchReport {
  double asked_cents = 0;
  double reached_cents = 0;      ///< worst mode of the best step
  std::size_t chosen = 0;        ///< that step
  std::vector<PitchStep> steps;  ///< in the order in which they were tried
  /// Empty when the target is met. Else what ended the search: max_elements, max_unknowns,
  /// memory_limit, order (4 is the highest, and the mesh cannot be refined), mesher (it failed),
  /// solver, no_progress or steps.
  std::string stopped_by;
  std::string reason;  ///< the same for a person

  bool met() const { return stopped_by.empty(); }
};

/// {asked_cents, reached_cents, met, stopped_by, reason, chosen, steps: [{order, element_size_m,
/// automatic_size, edge_layers, elements, unknowns, seconds, worst_cents, median_cents}]};
/// stopped_by and reason are null when the target is met.
/// @param with_seconds  false leaves out what differs from run to run
nlohmann::json to_json(const PitchReport& report, bool with_seconds);

}  // namespace carillon::solvers::pitch
