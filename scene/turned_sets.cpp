#include "scene/turned_sets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/hash.hpp"
#include "solvers/axisymmetric/solve_axisymmetric.hpp"
#include "solvers/eigen/cached_modes.hpp"
#include "solvers/families/families.hpp"
#include "solvers/libraries/environment.hpp"
#include "solvers/libraries/library_versions.hpp"
#include "solvers/modes/modes_broadcast.hpp"

namespace carillon::scene {
namespace {

/// Part of every key: raise it when solve_axisymmetric() gives other values for equal input, or
/// files of modes another layout.
constexpr std::string_view solver_version = "carillon axisymmetric 6";

/// All sets lie on one surface, which depends on each of them.
std::string key_of(const solvers::mesh::GeneratedShape& shape,
                   std::span<const solvers::basis::ModeRequest> sets,
                   const TurnedOptions& options) {
  core::Sha256 hash;
  hash.add(solver_version);
  hash.add(solvers::libraries::solver_options());
  for (const auto& [library, version] : solvers::libraries::library_versions())
    hash.add(fmt::format(" {} {}", library, version));
  hash.add(shape.family);
  for (const auto& [name, value] : shape.parameters)
    hash.add(name).add(std::span<const double>(&value, 1));
  for (const auto& point : shape.profile) hash.add(std::span<const double>(point));
  std::vector<double> numbers = {options.solve.tolerance, options.solve.estimate_errors ? 1.0 : 0.0,
                                 options.pitch_cents, options.cell};
  for (const solvers::basis::ModeRequest& set : sets) {
    const std::vector<double> material = solvers::elements::identity_of(set.regions.front());
    numbers.insert(numbers.end(), material.begin(), material.end());
    numbers.insert(numbers.end(), {set.band.min_frequency, set.band.max_frequency,
                                   static_cast<double>(set.band.max_modes), set.band.counted_from});
  }
  hash.add(std::span<const double>(numbers));
  return hash.hex();
}

std::vector<solvers::modes::Modes> solve_sets(const solvers::mesh::GeneratedShape& shape,
                                              std::span<const solvers::basis::ModeRequest> sets,
                                              const TurnedOptions& options,
                                              const std::filesystem::path& cache,
                                              core::Trace& trace) {
  const std::string key = cache.empty() ? "" : key_of(shape, sets, options);
  const auto key_of_set = [&key](std::size_t s) { return fmt::format("{}-{}", key, s); };
  std::vector<solvers::modes::Modes> stored;
  while (!cache.empty() && stored.size() < sets.size()) {
    auto modes = solvers::eigen::load_modes(cache, key_of_set(stored.size()), MPI_COMM_SELF, trace);
    if (!modes) break;
    stored.push_back(std::move(*modes));
  }
  if (stored.size() == sets.size()) return stored;
  std::vector<solvers::axisymmetric::MaterialBand> wanted;
  for (const solvers::basis::ModeRequest& set : sets)
    wanted.push_back({set.regions.front(), set.band});
  auto solved = solvers::axisymmetric::solve_axisymmetric(
      solvers::families::find_family(shape.family).meridian(shape), wanted, options.solve,
      {.cell = options.cell, .pitch_target = options.pitch_cents}, trace);
  for (std::size_t s = 0; s < sets.size() && !cache.empty(); ++s)
    solvers::eigen::store_modes(cache, key_of_set(s), solved[s], MPI_COMM_SELF);
  return solved;
}

/// What came of a pitch target.
solvers::pitch::PitchReport report_of(const std::vector<solvers::modes::Modes>& sets,
                                      double cents) {
  solvers::pitch::PitchReport report;
  report.asked_cents = cents;
  for (const solvers::modes::Modes& modes : sets)
    for (const double error : modes.pitch_errors)
      report.reached_cents = std::max(report.reached_cents, error);
  if (cents > 0 && !(report.reached_cents <= cents)) {
    report.stopped_by = "no_progress";
    report.reason = "a higher order and smaller cells did not bring it there";
  }
  return report;
}

}  // namespace

double longest_side_of_turned(const solvers::mesh::GeneratedShape& shape) {
  const auto& family = solvers::families::find_family(shape.family);
  return solvers::mesh::measure(family.meridian(shape)).longest_side();
}

solvers::pitch::PitchResult solve_turned(const solvers::mesh::GeneratedShape& shape,
                                         std::span<const solvers::basis::ModeRequest> sets,
                                         const TurnedOptions& options, MPI_Comm comm,
                                         const std::filesystem::path& cache, core::Trace& trace) {
  solvers::pitch::PitchResult result;
  result.mesh.mesh.region_names = {"body"};
  result.sets.resize(sets.size());
  mpi::agreed(comm, [&] {
    if (mpi::rank(comm) == 0) result.sets = solve_sets(shape, sets, options, cache, trace);
  });
  for (solvers::modes::Modes& modes : result.sets) solvers::modes::broadcast(modes, comm, 0);
  result.report = report_of(result.sets, options.pitch_cents);
  return result;
}

}  // namespace carillon::scene
