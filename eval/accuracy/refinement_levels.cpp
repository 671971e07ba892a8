#include "eval/accuracy/refinement_levels.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "scene/pitch.hpp"
#include "scene/solved_object.hpp"
#include "solvers/axisymmetric/solve_axisymmetric.hpp"
#include "solvers/eigen/cached_modes.hpp"
#include "solvers/families/families.hpp"
#include "solvers/mesh/surface_mesh.hpp"
#include "solvers/modes/modes_broadcast.hpp"
#include "solvers/pitch/pitch_model.hpp"

namespace carillon::eval::accuracy {

namespace {

/// Modes of a level beyond those compared: a set never ends within a cluster, and the last mode
/// compared may have come near the next.
constexpr int spare_modes = 2;

/// Whether a mode below a set's k-th could be missing, and ranks be wrong. Counts end half way
/// between modes, so that only rounding has to be forgiven.
bool may_miss(const solvers::modes::Modes& modes, std::size_t k) {
  return modes.certificate.complete_to_hz < (1 - 1e-6) * modes.frequency(k);
}

/// Sizes near each other give the same cells, their nodes a rounding apart.
bool same_but_for_rounding(const solvers::mesh::TetMesh& a, const solvers::mesh::TetMesh& b) {
  if (a.order != b.order || a.elements != b.elements || a.nodes.size() != b.nodes.size()) {
    return false;
  }
  const double rounding = 1e-12 * solvers::mesh::bounding_box(a.nodes).longest_side();
  return std::equal(
      a.nodes.begin(), a.nodes.end(), b.nodes.begin(),
      [rounding](const auto& x, const auto& y) { return (x - y).norm() <= rounding; });
}

/// Processor time of this process and of the meshers that it has started [s].
double cpu_seconds() {
  double sum = 0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    for (const timeval& t : {usage.ru_utime, usage.ru_stime}) {
      sum += static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    }
  }
  return sum;
}

}  // namespace

LevelRunner::LevelRunner(const AccuracyConfig& config, const StudiedObject& object,
                         std::string cache, MPI_Comm comm)
    : config_(config), object_(object), cache_(std::move(cache)), comm_(comm) {}

solvers::modes::Band LevelRunner::target_band() const {
  solvers::modes::Band band;
  band.min_frequency = 0;
  band.max_frequency = 2 * reference_.frequencies.back();
  band.max_modes = static_cast<int>(reference_.frequencies.size());
  return band;
}

std::vector<solvers::elements::Elastic> LevelRunner::regions(
    const solvers::mesh::MeshResult& mesh) const {
  return {mesh.mesh.region_names.size(), object_.material.elastic};
}

solvers::modes::Modes LevelRunner::axisymmetric_modes(const solvers::eigen::SolveOptions& options,
                                                      core::Trace& trace) const {
  solvers::modes::Modes modes;
  mpi::agreed(comm_, [&] {
    if (mpi::rank(comm_) != 0) return;
    const auto& shape = object_.request.shape;
    modes = solvers::axisymmetric::solve_axisymmetric(
        solvers::families::find_family(shape.family).meridian(shape), object_.material.elastic,
        options, {}, trace);
  });
  solvers::modes::broadcast(modes, comm_);
  return modes;
}

const Reference& LevelRunner::reference() {
  const double start = core::monotonic_seconds();
  Reference reference;
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  options.band = {0, config_.band.max_frequency, config_.band.max_modes,
                  config_.band.min_frequency};
  solvers::modes::Modes modes;
  const std::string& family = object_.request.shape.family;
  const bool turned = !family.empty() && solvers::families::find_family(family).meridian != nullptr;
  if (turned && config_.reference != ReferenceSolver::tetrahedra) {
    modes = axisymmetric_modes(options, trace);
    reference.solver = "axisymmetric";
  } else {
    solvers::mesh::MeshRequest request = object_.request;
    request.options.order = config_.reference_order;
    request.options.max_elements = config_.max_elements;
    request.options.element_size =
        object_.reference_factor * automatic_size(config_.reference_order);
    const auto mesh = scene::shared_mesh(request, {}, cache_, comm_);
    modes = solvers::eigen::cached_modes(mesh.mesh, regions(mesh), options, comm_, cache_, trace);
    reference.solver = "tetrahedra";
    reference.order = config_.reference_order;
    reference.element_size = request.options.element_size;
  }
  reference.unknowns = modes.certificate.unknowns;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    reference.frequencies.push_back(modes.frequency(k));
    if (modes.frequency(k) < config_.band.min_frequency) {
      ++reference.first;
    } else if (k < modes.pitch_errors.size()) {
      reference.worst_cents = std::max(reference.worst_cents, modes.pitch_errors[k]);
    }
  }
  if (reference.compared() == 0) {
    throw core::SolverError(fmt::format("no mode lies between {:.6g} and {:.6g} Hz to compare",
                                        config_.band.min_frequency, config_.band.max_frequency));
  }
  if (may_miss(modes, modes.size() - 1)) {
    throw core::SolverError(fmt::format("the reference may miss a mode above {:.6g} Hz",
                                        modes.certificate.complete_to_hz));
  }
  reference.seconds = core::monotonic_seconds() - start;
  return reference_ = std::move(reference);
}

double LevelRunner::automatic_size(int order) {
  const auto known = automatic_sizes_.find(order);
  if (known != automatic_sizes_.end()) return known->second;
  solvers::mesh::MeshRequest request = object_.request;
  request.options.order = order;
  request.options.max_elements = config_.max_elements;
  const auto mesh = scene::shared_mesh(request, {}, cache_, comm_);
  return automatic_sizes_[order] = solvers::pitch::size_of(mesh.mesh).element_size;
}

const RefinementLevel& LevelRunner::at_factor(int order, double size_factor, double tolerance) {
  solvers::mesh::MeshOptions options;
  options.order = order;
  options.max_elements = config_.max_elements;
  try {
    if (size_factor != 1) options.element_size = size_factor * automatic_size(order);
  } catch (const core::Error& error) {
    auto level = std::make_unique<RefinementLevel>();
    // A factor on a size that there is not; it is no other level's either.
    options.element_size = std::numeric_limits<double>::quiet_NaN();
    level->options = options;
    level->tolerance = tolerance;
    level->size_factor = size_factor;
    level->element_size = options.element_size;
    level->failure = error.message();
    level->error = std::current_exception();
    levels_.push_back(std::move(level));
    return *levels_.back();
  }
  return run(options, tolerance, size_factor);
}

const RefinementLevel& LevelRunner::run(const solvers::mesh::MeshOptions& options, double tolerance,
                                        double size_factor) {
  for (const auto& level : levels_) {
    if (level->options.order == options.order &&
        level->options.edge_layers == options.edge_layers && level->tolerance == tolerance &&
        std::abs(level->options.element_size - options.element_size) <=
            1e-9 * options.element_size) {
      return *level;
    }
  }
  levels_.push_back(std::make_unique<RefinementLevel>());
  RefinementLevel& level = *levels_.back();
  level.options = options;
  level.tolerance = tolerance;
  level.size_factor = size_factor;
  const bool automatic = options.element_size <= 0;
  level.element_size = automatic ? std::numeric_limits<double>::quiet_NaN() : options.element_size;
  try {
    // Rank 0's clock decides for all whether a run was long enough.
    do {
      run_once(level);
      const double seconds = std::stod(mpi::broadcast(std::to_string(level.seconds), 0, comm_));
      if (seconds >= config_.repeat_below) break;
    } while (level.runs < config_.max_runs);
    if (automatic) level.element_size = solvers::pitch::size_of(level.mesh.mesh).element_size;
    look_for_partners(level);
  } catch (const core::Error& error) {
    level.failure = error.message();
    level.error = std::current_exception();
  }
  return level;
}

const RefinementLevel* LevelRunner::same_elements(const RefinementLevel& level) const {
  const auto found = std::find_if(levels_.begin(), levels_.end(), [&level](const auto& other) {
    return other.get() != &level && !other->error && other->tolerance == level.tolerance &&
           same_but_for_rounding(other->mesh.mesh, level.mesh.mesh);
  });
  return found == levels_.end() ? nullptr : found->get();
}

void LevelRunner::look_for_partners(RefinementLevel& level) const {
  const std::size_t wanted = reference_.frequencies.size();
  if (level.modes.size() < wanted) {
    level.failure =
        fmt::format("finds {} of the {} modes below {:.6g} Hz, though it searched to {:.6g}",
                    level.modes.size(), wanted, reference_.frequencies.back(),
                    level.modes.certificate.max_frequency);
  } else if (may_miss(level.modes, wanted - 1)) {
    level.failure =
        fmt::format("may miss a mode above {:.6g} Hz", level.modes.certificate.complete_to_hz);
  }
}

void LevelRunner::run_once(RefinementLevel& level) {
  solvers::mesh::MeshRequest request = object_.request;
  request.options = level.options;
  core::Trace trace;
  const double start = core::monotonic_seconds(), cpu = cpu_seconds();
  {
    const core::ScopedTimer timer(trace.stages["mesh"]);
    level.mesh = scene::shared_mesh(request, {}, {}, comm_);
  }
  if (const RefinementLevel* same = level.runs == 0 ? same_elements(level) : nullptr) {
    level.modes = same->modes;
    level.seconds = same->seconds;
    level.cpu_seconds = same->cpu_seconds;
    level.stages = same->stages;
    level.runs = same->runs;
    return;
  }
  solvers::eigen::SolveOptions solve;
  solve.band = target_band();
  solve.band.max_modes += spare_modes;
  solve.tolerance = level.tolerance;
  level.modes =
      solvers::eigen::solve_modes(level.mesh.mesh, regions(level.mesh), solve, comm_, trace);
  const double seconds = core::monotonic_seconds() - start, spent = cpu_seconds() - cpu;
  const bool better = config_.cpu_time ? spent < level.cpu_seconds : seconds < level.seconds;
  if (++level.runs > 1 && !better) return;
  level.seconds = seconds;
  level.cpu_seconds = spent;
  for (const auto& [stage, entry] : trace.stages) level.stages[stage] = entry.seconds;
}

solvers::pitch::PitchReport LevelRunner::choose(double cents) {
  scene::PitchSearch search;
  search.request = object_.request;
  search.request.options.max_elements = config_.max_elements;
  search.cents = cents;
  const RefinementLevel* current = nullptr;
  const auto make_mesh = [&](const solvers::mesh::MeshOptions& options) {
    current = &run(options, solvers::eigen::SolveOptions().tolerance);
    // The kind of error tells the search what to try next.
    if (current->error) std::rethrow_exception(current->error);
    return current->mesh;
  };
  const auto solve = [&](const solvers::mesh::MeshResult&) {
    return std::vector{solvers::modes::restrict_to(current->modes, target_band())};
  };
  return solvers::pitch::reach_pitch(scene::pitch_target(search), make_mesh, solve).report;
}

std::size_t LevelRunner::level_of(const solvers::pitch::PitchStep& step) const {
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    const RefinementLevel& level = *levels_[i];
    const bool automatic = level.options.element_size <= 0;
    if (level.options.order == step.order && level.options.edge_layers == step.edge_layers &&
        automatic == step.automatic_size &&
        level.tolerance == solvers::eigen::SolveOptions().tolerance &&
        std::abs(level.element_size / step.element_size - 1) < 1e-9 && !level.error) {
      return i;
    }
  }
  throw core::SolverError("a setting was chosen that was never run");
}

}  // namespace carillon::eval::accuracy
