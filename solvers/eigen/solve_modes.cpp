#include "solvers/eigen/solve_modes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "solvers/assembly/assemble.hpp"
#include "solvers/eigen/extract.hpp"
#include "solvers/eigen/mirrored_solve.hpp"
#include "solvers/eigen/pitch_error.hpp"
#include "solvers/eigen/search.hpp"
#include "solvers/eigen/select.hpp"
#include "solvers/mesh/conformity.hpp"

namespace carillon::solvers::eigen {
namespace {

constexpr std::int64_t alone_below = 1000;

void require(bool holds, const std::string& message) {
  if (!holds) throw core::InputError(message);
}

}  // namespace

void check_band(const modes::Band& band) {
  require(
      band.min_frequency >= 0 && band.max_frequency > band.min_frequency &&
          std::isfinite(band.max_frequency),
      fmt::format("the band from {} to {} Hz is empty", band.min_frequency, band.max_frequency));
  require(band.max_modes >= 1, "max_modes must be at least 1");
}

void check_input(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                 const modes::Band& band) {
  require(mesh.element_count() > 0, "the mesh has no elements");
  require(mesh.order >= 1 && mesh.order <= 4,
          fmt::format("elements of order {} are not known; 1 to 4 are", mesh.order));
  require(mesh.elements.size() ==
              mesh.element_count() *
                  static_cast<std::size_t>(elements::nodes_per_tetrahedron(mesh.order)),
          "the mesh's elements and regions differ in number");
  const auto inside = [](const std::vector<std::int32_t>& list, std::size_t count) {
    return std::all_of(list.begin(), list.end(), [count](std::int32_t i) {
      return i >= 0 && static_cast<std::size_t>(i) < count;
    });
  };
  require(inside(mesh.elements, mesh.nodes.size()) && inside(mesh.faces, mesh.nodes.size()),
          "the mesh refers to nodes that do not exist");
  require(
      inside(mesh.regions, regions.size()),
      fmt::format("the mesh has regions that no material is given for ({} given)", regions.size()));
  require(std::all_of(mesh.nodes.begin(), mesh.nodes.end(),
                      [](const Vec3& x) { return x.allFinite(); }),
          "a node of the mesh is not a finite point");
  for (const auto& region : regions) elements::check_elastic(region);
  check_band(band);
  mesh::refuse_overlaps(mesh);
}

bool too_small_to_split(const mesh::TetMesh& mesh, MPI_Comm comm) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  return ranks > 1 && 3 * static_cast<std::int64_t>(mesh.nodes.size()) < alone_below;
}

namespace {

double total_mass(const assembly::System& system, MPI_Comm comm) {
  double sum = 0;
  for (const double m : system.mass) sum += m;
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm);
  return sum * system.scales.density * std::pow(system.scales.length, 3);
}

}  // namespace

modes::Modes select_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                          const modes::Band& band, const assembly::System& system,
                          const SearchResult& found, MPI_Comm comm,
                          std::vector<std::size_t>* chosen) {
  modes::Modes modes;
  std::vector<std::int32_t> surface_nodes;
  mpi::agreed_in_group(comm, [&] { modes.surface = surface_of(mesh, surface_nodes); });
  modes.mass = total_mass(system, comm);

  // Eigenvalues are recomputed from element energies, which may exchange neighbours.
  auto fields =
      extract_fields(mesh, regions, system, found.pairs, found.flexible, surface_nodes, comm);
  std::vector<std::size_t> order;
  std::int64_t below = 0;
  for (std::size_t k = 0; k < fields.eigenvalues.size(); ++k) {
    const double frequency = std::sqrt(fields.eigenvalues[k]) / (2 * std::numbers::pi);
    if (frequency < band.min_frequency) {
      ++below;
    } else if (frequency <= band.max_frequency) {
      order.push_back(k);
    }
  }
  std::stable_sort(order.begin(), order.end(), [&fields](std::size_t a, std::size_t b) {
    return fields.eigenvalues[a] < fields.eigenvalues[b];
  });
  const auto in_band = order.size();
  std::vector<double> ascending;
  auto maximum = static_cast<std::size_t>(band.max_modes);
  for (const auto k : order) {
    ascending.push_back(fields.eigenvalues[k]);
    maximum += std::sqrt(fields.eigenvalues[k]) < 2 * std::numbers::pi * band.bottom();
  }
  order.resize(modes::whole_clusters(ascending, maximum));

  const auto rows = static_cast<Eigen::Index>(order.size());
  const auto region_count = static_cast<Eigen::Index>(regions.size());
  modes::ModeShapes::Rows shapes(rows, fields.shapes.cols());
  modes.kinetic_fraction.resize(rows, region_count);
  modes.strain_fraction.resize(rows, region_count);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const auto k = order[static_cast<std::size_t>(row)];
    const auto from = static_cast<Eigen::Index>(k);
    modes.eigenvalues.push_back(fields.eigenvalues[k]);
    if (chosen) chosen->push_back(found.flexible[k]);
    modes.residuals.push_back(found.pairs.residuals[found.flexible[k]]);
    shapes.row(row) = fields.shapes.row(from);
    modes.kinetic_fraction.row(row) = fields.kinetic_fraction.row(from);
    modes.strain_fraction.row(row) = fields.strain_fraction.row(from);
  }
  modes.shapes = modes::ModeShapes(std::move(shapes));

  auto& certificate = modes.certificate;
  certificate.min_frequency = band.min_frequency;
  certificate.max_frequency = band.max_frequency;
  certificate.components = found.components;
  certificate.rigid_modes =
      static_cast<int>(system.mirror.rigid_motions().size()) * found.components;
  certificate.unknowns = system.free_unknowns();
  certificate.orthonormality = found.pairs.orthonormality;
  certificate.max_residual =
      modes.residuals.empty() ? 0
                              : *std::max_element(modes.residuals.begin(), modes.residuals.end());
  certificate.count_verified = found.counted;
  certificate.eigen_solver = found.eigen_solver;
  certificate.linear_solver = found.linear_solver;
  certificate.modes_found = static_cast<std::int64_t>(modes.size());
  const double known_to = system.scales.to_frequency(found.verified_below);
  certificate.modes_in_band = found.all_verified || known_to >= band.max_frequency
                                  ? static_cast<std::int64_t>(in_band)
                                  : found.flexible_below_top - below;
  certificate.complete = certificate.modes_found == certificate.modes_in_band;
  if (certificate.complete) {
    certificate.complete_to_hz = band.max_frequency;
  } else {
    // Half way to the first mode that is left out, as far as a count vouches for it.
    double limit = known_to;
    if (order.size() < in_band) {
      const double last = modes.eigenvalues.back();
      double next = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < fields.eigenvalues.size(); ++k) {
        const bool taken = std::find(order.begin(), order.end(), k) != order.end();
        if (!taken && fields.eigenvalues[k] >= last) next = std::min(next, fields.eigenvalues[k]);
      }
      limit = std::min(limit, std::sqrt((last + next) / 2) / (2 * std::numbers::pi));
    }
    certificate.complete_to_hz = std::min(limit, band.max_frequency);
  }
  return modes;
}

modes::Modes solve_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                         const SolveOptions& options, MPI_Comm comm, core::Trace& trace) {
  return solve_modes(mesh, regions, options, comm, trace, SearchMethods());
}

namespace {

/// Modes of one class on a part, or of all fields on a body.
ClassModes solve_class(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                       const SolveOptions& options, const assembly::MirrorClass& mirror,
                       const ErrorMargins* margins, MPI_Comm comm, core::Trace& trace,
                       const SearchMethods& methods) {
  if (too_small_to_split(mesh, comm)) {
    ClassModes alone;
    mpi::agreed_in_group(comm, [&] {
      alone = solve_class(mesh, regions, options, mirror, margins, MPI_COMM_SELF, trace, methods);
    });
    return alone;
  }
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  assembly::Partition part;
  {
    const core::ScopedTimer timer(trace.stages["partition"]);
    mpi::agreed_in_group(comm, [&] { part = assembly::partition(mesh, ranks); });
  }
  assembly::System system;
  {
    const core::ScopedTimer timer(trace.stages["assemble"]);
    system = assembly::assemble(mesh, regions, std::move(part), comm, mirror);
  }
  ClassModes out;
  const auto found = search_modes(mesh, regions, options, system, comm, trace, methods);
  std::vector<std::size_t> chosen;
  {
    const core::ScopedTimer timer(trace.stages["extract"]);
    out.modes = select_modes(mesh, regions, options.band, system, found, comm, &chosen);
  }
  if (options.estimate_errors && !chosen.empty()) {
    const core::ScopedTimer timer(trace.stages["estimate"]);
    const auto memory = std::min(options.memory_limit / 4, found.spare_memory);
    out.truth = estimate_true_modes(mesh, regions, system, found, chosen, out.modes.eigenvalues,
                                    memory, comm, margins)
                    .modes;
  }
  return out;
}

}  // namespace

modes::Modes solve_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                         const SolveOptions& options, MPI_Comm comm, core::Trace& trace,
                         const SearchMethods& methods) {
  std::optional<PartToSolve> body;
  mpi::agreed_in_group(comm, [&] { check_input(mesh, regions, options.band); });
  if (mesh.faces.empty()) {
    mesh::TetMesh bounded = mesh;
    bounded.faces = mesh::boundary_faces(mesh);
    return solve_modes(bounded, regions, options, comm, trace, methods);
  }
  mpi::agreed_in_group(comm,
                       [&] { body = part_to_solve(mesh, regions, options, mpi::size(comm)); });
  if (body) {
    const SolveClass solve = [&](const assembly::MirrorClass& mirror,
                                 std::span<const modes::Band> bands, const SolveOptions& limits,
                                 MPI_Comm group) {
      SolveOptions own = limits;
      own.band = bands.front();
      std::vector<std::optional<ClassModes>> out;
      out.emplace_back(solve_class(body->part.mesh, regions, own, mirror, &body->margins, group,
                                   trace, methods));
      return out;
    };
    auto joined = solve_classes(mesh, *body, {&options.band, 1}, options, solve, comm);
    if (joined.front()) return std::move(*joined.front());
  }
  auto [modes, truth] = solve_class(mesh, regions, options, {}, nullptr, comm, trace, methods);
  if (!truth.empty()) modes.pitch_errors = pitch_errors(modes.eigenvalues, std::move(truth));
  return std::move(modes);
}

}  // namespace carillon::solvers::eigen
