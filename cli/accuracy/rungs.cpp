#include "cli/accuracy/rungs.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "cli/body.hpp"
#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "solvers/families.hpp"
#include "solvers/fourier_modes.hpp"
#include "solvers/modes_broadcast.hpp"
#include "solvers/modes_file.hpp"
#include "solvers/pitch_model.hpp"

namespace carillon::cli {

namespace {

/// Modes of the reference beyond those compared: the last one compared may be half of a pair.
constexpr int spare_modes = 6;

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

RungRunner::RungRunner(const LadderConfig& config, const LadderObject& object,
                       const Context& context, MPI_Comm comm)
    : config_(config), object_(object), context_(context), comm_(comm) {}

solvers::SolveOptions RungRunner::solve_options(double tolerance, int modes) const {
  solvers::SolveOptions options;
  options.band.min_frequency = config_.min_frequency;
  options.band.max_frequency = config_.max_frequency;
  options.band.max_modes = modes;
  options.tolerance = tolerance;
  return options;
}

std::vector<solvers::Elastic> RungRunner::regions(const solvers::MeshResult& mesh) const {
  return {mesh.mesh.region_names.size(), object_.material.elastic};
}

solvers::Modes RungRunner::fourier_modes(core::Trace& trace) const {
  solvers::Modes modes;
  mpi::agreed(comm_, [&] {
    if (mpi::rank(comm_) != 0) return;
    const auto& shape = object_.request.shape;
    modes = solvers::solve_fourier(solvers::find_family(shape.family).meridian(shape),
                                   object_.material.elastic,
                                   solve_options(1e-12, config_.modes + spare_modes), {}, trace);
  });
  solvers::broadcast(modes, comm_);
  return modes;
}

Reference RungRunner::reference() {
  const double start = core::monotonic_seconds();
  Reference reference;
  core::Trace trace;
  solvers::Modes modes;
  const std::string& family = object_.request.shape.family;
  const bool turned = !family.empty() && solvers::find_family(family).meridian != nullptr;
  if (config_.reference == ReferenceSolver::fourier && !turned) {
    throw core::InputError(object_.name + ": not a body of revolution",
                           "reference.solver: automatic takes tetrahedra for it");
  }
  if (turned && config_.reference != ReferenceSolver::tetrahedra) {
    modes = fourier_modes(trace);
    reference.solver = "fourier";
  } else {
    solvers::MeshRequest request = object_.request;
    request.options.order = config_.reference_order;
    request.options.max_elements = config_.max_elements;
    request.options.element_size = object_.reference_size * automatic_size(config_.reference_order);
    const auto mesh = shared_mesh(request, {}, context_.cache, comm_);
    modes = solvers::cached_modes(mesh.mesh, regions(mesh),
                                  solve_options(1e-12, config_.modes + spare_modes), comm_,
                                  context_.cache, trace);
    reference.solver = "tetrahedra";
    reference.order = config_.reference_order;
    reference.element_size = request.options.element_size;
  }
  reference.unknowns = modes.certificate.unknowns;
  for (std::size_t k = 0; k < modes.size(); ++k)
    reference.frequencies.push_back(modes.frequency(k));
  const auto compared =
      std::min<std::size_t>(modes.pitch_errors.size(), static_cast<std::size_t>(config_.modes));
  for (std::size_t k = 0; k < compared; ++k)
    reference.worst_cents = std::max(reference.worst_cents, modes.pitch_errors[k]);
  reference.seconds = core::monotonic_seconds() - start;
  return reference;
}

double RungRunner::automatic_size(int order) {
  const auto known = automatic_sizes_.find(order);
  if (known != automatic_sizes_.end()) return known->second;
  solvers::MeshRequest request = object_.request;
  request.options.order = order;
  request.options.max_elements = config_.max_elements;
  const auto mesh = shared_mesh(request, {}, context_.cache, comm_);
  return automatic_sizes_[order] = solvers::size_of(mesh.mesh).element_size;
}

const Rung& RungRunner::at_factor(int order, double size_factor, double tolerance) {
  solvers::MeshOptions options;
  options.order = order;
  options.max_elements = config_.max_elements;
  try {
    if (size_factor != 1) options.element_size = size_factor * automatic_size(order);
  } catch (const core::SolverError& error) {
    rungs_.push_back(std::make_unique<Rung>());
    rungs_.back()->options = options;
    rungs_.back()->tolerance = tolerance;
    rungs_.back()->failure = error.message();
    return *rungs_.back();
  }
  return run(options, tolerance);
}

const Rung& RungRunner::run(const solvers::MeshOptions& options, double tolerance) {
  for (const auto& rung : rungs_) {
    if (rung->options.order == options.order && rung->tolerance == tolerance &&
        std::abs(rung->options.element_size - options.element_size) <=
            1e-9 * options.element_size) {
      return *rung;
    }
  }
  auto rung = std::make_unique<Rung>();
  rung->options = options;
  rung->tolerance = tolerance;
  try {
    // Rank 0's clock decides for all whether a run was long enough.
    do {
      run_once(*rung);
      const double seconds = std::stod(mpi::broadcast(std::to_string(rung->seconds), 0, comm_));
      if (seconds >= config_.repeat_below) break;
    } while (rung->runs < config_.most_runs);
    rung->element_size = options.element_size > 0 ? options.element_size
                                                  : solvers::size_of(rung->mesh.mesh).element_size;
  } catch (const core::SolverError& error) {
    rung->failure = error.message();
  }
  rungs_.push_back(std::move(rung));
  return *rungs_.back();
}

void RungRunner::run_once(Rung& rung) {
  solvers::MeshRequest request = object_.request;
  request.options = rung.options;
  core::Trace trace;
  const double start = core::monotonic_seconds(), cpu = cpu_seconds();
  {
    const core::ScopedTimer timer(trace.stages["mesh"]);
    rung.mesh = shared_mesh(request, {}, {}, comm_);
  }
  rung.modes = solvers::solve_modes(rung.mesh.mesh, regions(rung.mesh),
                                    solve_options(rung.tolerance, config_.modes), comm_, trace);
  const double seconds = core::monotonic_seconds() - start, spent = cpu_seconds() - cpu;
  const bool better = config_.cpu_time ? spent < rung.cpu_seconds : seconds < rung.seconds;
  if (++rung.runs > 1 && !better) return;
  rung.seconds = seconds;
  rung.cpu_seconds = spent;
  for (const auto& [stage, entry] : trace.stages) rung.stages[stage] = entry.seconds;
}

solvers::PitchReport RungRunner::choose(double cents) {
  solvers::PitchTarget target;
  target.cents = cents;
  target.start.max_elements = config_.max_elements;
  const Rung* current = nullptr;
  const auto make_mesh = [&](const solvers::MeshOptions& options) {
    current = &run(options, solvers::tolerance_for(cents));
    if (!current->failure.empty()) throw core::SolverError(current->failure);
    return current->mesh;
  };
  const auto solve = [&](const solvers::MeshResult&) { return std::vector{current->modes}; };
  return solvers::reach_pitch(target, make_mesh, solve).report;
}

const Rung& RungRunner::rung_of(const solvers::PitchStep& step, double cents) const {
  for (const auto& rung : rungs_) {
    const bool automatic = rung->options.element_size <= 0;
    if (rung->options.order == step.order && automatic == step.automatic_size &&
        rung->tolerance == solvers::tolerance_for(cents) &&
        std::abs(rung->element_size / step.element_size - 1) < 1e-9 && rung->failure.empty()) {
      return *rung;
    }
  }
  throw core::SolverError("a setting was chosen that was never run");
}

}  // namespace carillon::cli
