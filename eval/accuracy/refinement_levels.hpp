#pragma once

#include <exception>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "eval/accuracy/accuracy_config.hpp"
#include "solvers/eigen/solve_modes.hpp"
#include "solvers/pitch/pitch_target.hpp"

namespace carillon::eval::accuracy {

/// One setting of one object, run afresh: mesh and modes with their estimated errors, no cache.
struct RefinementLevel {
  solvers::mesh::MeshOptions options;
  double tolerance = 1e-12;
  double size_factor = 0;  ///< on the automatic size; 0: asked for by a target
  /// As asked for [m]; the longest edge where it was automatic; NaN where it cannot be known.
  double element_size = 0;
  double seconds = 0;      ///< wall time of the fastest run
  double cpu_seconds = 0;  ///< processor time of the same run, mesher included
  int runs = 0;
  std::map<std::string, double> stages;  ///< [s] of that run
  std::string failure;                   ///< why it cannot be compared, else ""
  std::exception_ptr error;  ///< what was thrown; null where the modes are merely too few
  solvers::mesh::MeshResult mesh;
  solvers::modes::Modes modes;  ///< from the object's first
};

/// Modes that the levels are compared with. Ranks count from the object's first flexible mode, so
/// that a mode that is a little sharper on one side of min_frequency does not shift them.
struct Reference {
  std::string solver;       ///< axisymmetric or tetrahedra
  int order = 0;            ///< of the elements
  double element_size = 0;  ///< [m]; 0 for harmonics
  std::int64_t unknowns = 0;
  double seconds = 0;               ///< spent on it in this run
  double worst_cents = 0;           ///< its own estimated error
  std::vector<double> frequencies;  ///< [Hz], from the object's first to the last compared
  std::size_t first = 0;            ///< those below min_frequency, which are not compared

  std::size_t compared() const { return frequencies.size() - first; }
};

/// Runs the levels of one object, each setting once.
class LevelRunner {
 public:
  /// @param object  stays alive as long as the runner
  /// @param cache   folder of meshes and modes; empty: none is kept
  LevelRunner(const AccuracyConfig& config, const StudiedObject& object, std::string cache,
              MPI_Comm comm);

  /// Much finer than any level; kept in the cache. Comes before any level.
  /// @throws SolverError, InputError  there is none, or it has no mode in the band
  const Reference& reference();

  /// What a target judges: from the object's first mode to the last compared, and so many modes
  /// below twice its frequency. Levels search a few modes more; one too coarse to find them there
  /// fails.
  solvers::modes::Band target_band() const;

  /// Longest edge that an order takes by itself [m].
  double automatic_size(int order);

  /// A setting, from what was run before where it was.
  /// @param size_factor  on the automatic size; 1: the automatic mesh itself
  const RefinementLevel& at_factor(int order, double size_factor, double tolerance);
  const RefinementLevel& run(const solvers::mesh::MeshOptions& options, double tolerance,
                             double size_factor = 0);

  /// What --pitch-cents chooses. The levels that it tries are run like all others.
  /// @throws Error  its first setting fails
  solvers::pitch::PitchReport choose(double cents);
  /// Which of the levels a step towards a target is.
  std::size_t level_of(const solvers::pitch::PitchStep& step) const;

  /// Every level so far, in the order of running.
  const std::vector<std::unique_ptr<RefinementLevel>>& levels() const { return levels_; }

 private:
  std::vector<solvers::elements::Elastic> regions(const solvers::mesh::MeshResult& mesh) const;
  void run_once(RefinementLevel& level);
  /// An earlier level that has the same elements, nodes and tolerance: its modes are these.
  const RefinementLevel* same_elements(const RefinementLevel& level) const;
  void look_for_partners(RefinementLevel& level) const;
  solvers::modes::Modes axisymmetric_modes(const solvers::eigen::SolveOptions& options,
                                           core::Trace& trace) const;

  const AccuracyConfig& config_;
  const StudiedObject& object_;
  const std::string cache_;
  MPI_Comm comm_;
  Reference reference_;
  std::map<int, double> automatic_sizes_;
  std::vector<std::unique_ptr<RefinementLevel>> levels_;
};

}  // namespace carillon::eval::accuracy
