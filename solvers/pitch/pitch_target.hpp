#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "solvers/mesh/shape_source.hpp"
#include "solvers/modes/modes.hpp"
#include "solvers/pitch/pitch_report.hpp"

namespace carillon::solvers::pitch {

/// Estimates say nothing below this [cent]: the least that can be asked for. What the eigensolver's
/// usual tolerance leaves is ten times less, so there is nothing to refine about it.
constexpr double min_pitch_target = 0.01;
/// Estimates may be a fifth too low: a target is met where they are below this share of it.
constexpr double trusted_share = 0.8;
/// What `modes` and `build` aim at where nothing is said [cent], and what a setting may cost.
constexpr double usual_pitch_target = 5;
constexpr std::int64_t usual_max_unknowns = 120000;

/// A target as users write it: cents, or "off" (also 0), which gives 0.
/// @throws InputError  neither, or below min_pitch_target
double parse_pitch_target(const std::string& text);

/// How accurate pitches are to be, and where to begin.
struct PitchTarget {
  double cents = 5;              ///< the worst mode's pitch error may be so much [cent]
  mesh::MeshOptions start = {};  ///< first setting; max_elements bounds all of them
  bool fixed_mesh = false;       ///< elements are given (an MSH file): only their order can rise
  modes::LinearSolver linear_solver = modes::LinearSolver::automatic;
  std::int64_t memory_limit = 16ll << 30;  ///< of a direct factor [byte]
  /// Of all settings but the first, whose order alone is lowered for them.
  std::int64_t max_unknowns = std::numeric_limits<std::int64_t>::max();
};

struct PitchResult {
  mesh::MeshResult mesh;
  std::vector<modes::Modes> sets;  ///< of the chosen step, as `solve` gave them
  PitchReport report;
};

/// Makes the mesh of a setting.
using MeshMaker = std::function<mesh::MeshResult(const mesh::MeshOptions&)>;
/// Mode sets of a mesh that must all meet the target, with their pitch_errors.
using ModeSolver = std::function<std::vector<modes::Modes>(const mesh::MeshResult&)>;

/// The band that a target's modes are sought in. Coarse elements make modes sharp: some that belong
/// into the band are found above it, and are judged as well. A whole tone more.
modes::Band judged_band(const modes::Band& band);
/// A set of such a band without what lies above the band that was asked for.
modes::Modes without_margin(const modes::Modes& modes);

/// Solves, reads the estimated pitch errors, and refines until the worst mode's is below the target
/// by a fifth, as much as estimates may be too low, or something stops it: each step takes the
/// order from 2 to 4 and the size that should meet it at the least cost (pitch_model.hpp, corrected
/// by the rates that were measured). A first setting better than asked is kept: a coarser one would
/// come on top of it. Layers at inward edges are as many as the target takes; one more comes on top
/// where steps gain less than the rates say. When the target is out of reach, the best that the
/// bounds allow is tried before it gives up.
///
/// The choice follows from counts and estimates alone, never from the clock or from what a machine
/// has free, so it is the same everywhere: a step that runs out of time or memory ends the search
/// with its error.
///
/// @param probe  where not all sets are needed to see that a setting falls short: solves one whose
///               modes are as far off as any's. `solve` is then asked when it meets the target, and
///               in the end for the setting that is chosen.
/// @throws InputError   the target is below min_pitch_target or no number, or modes come without
///                      pitch_errors; and what make_mesh and solve throw
/// @throws SolverError  the first setting failed
/// @throws ResourceError  any setting ran out of time or memory
/// @note Collective where make_mesh and solve are.
PitchResult reach_pitch(const PitchTarget& target, const MeshMaker& make_mesh,
                        const ModeSolver& solve, const ModeSolver& probe = {});

}  // namespace carillon::solvers::pitch
