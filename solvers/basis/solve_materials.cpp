#include "solvers/basis/solve_materials.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/hash.hpp"
#include "core/numbers.hpp"
#include "mpi/comm.hpp"
#include "solvers/basis/detail/poisson_basis.hpp"
#include "solvers/eigen/cached_modes.hpp"
#include "solvers/eigen/mirrored_solve.hpp"
#include "solvers/eigen/select.hpp"

namespace carillon::solvers::basis {
namespace {

/// What the basis may add to a pitch [cents].
constexpr double largest_basis_error = 0.1;

/// Frequencies of a request over those of the body that its group solves.
double speed(const ModeRequest& request, std::span<const elements::Elastic> solved) {
  const auto& own = request.regions[0];
  return std::sqrt(own.youngs_modulus / solved[0].youngs_modulus * solved[0].density / own.density);
}

modes::Band scaled(const modes::Band& band, double factor) {
  return {band.min_frequency * factor, band.max_frequency * factor, band.max_modes,
          band.counted_from * factor};
}

/// A band that holds those of all requests, on the body of `solved`.
modes::Band snapshot_band(std::span<const ModeRequest> requests, const SolveGroup& group,
                          std::span<const elements::Elastic> solved) {
  modes::Band out{std::numeric_limits<double>::infinity(), 0, 0, 0};
  for (const auto i : group.requests) {
    const auto band = scaled(requests[i].band, 1 / speed(requests[i], solved));
    out.min_frequency = std::min(out.min_frequency, band.min_frequency);
    out.max_frequency = std::max(out.max_frequency, band.max_frequency);
    out.max_modes = std::max(out.max_modes, band.max_modes);
    out.counted_from = std::max(out.counted_from, band.bottom());
  }
  out.max_frequency *= beyond;
  out.max_modes = static_cast<int>(std::min(1e9, std::ceil(beyond * out.max_modes) + 8));
  return out;
}

/// A request's modes from the basis, unless they cannot be certified.
std::optional<eigen::ClassModes> from_basis(const mesh::TetMesh& mesh, const PoissonBasis& basis,
                                            const ModeRequest& request, MPI_Comm comm) {
  const double factor = speed(request, basis.regions);
  const auto band = scaled(request.band, 1 / factor);
  const double ratio = request.regions[0].poisson_ratio;
  auto regions = basis.regions;
  for (auto& region : regions) region.poisson_ratio = ratio;
  const auto& scales = basis.system->scales;
  const auto ritz = ritz_modes(mesh, basis, ratio,
                               {scales.from_frequency(band.bottom()),
                                scales.from_frequency(band.max_frequency), band.max_modes},
                               comm);
  eigen::ClassModes out;
  auto& modes = out.modes;
  modes = eigen::select_modes(mesh, regions, band, *basis.system, ritz.found, comm);

  const auto& own = request.regions[0];
  const double unit = scales.eigenvalue() * factor * factor;
  double error = 0;
  const auto& values = ritz.found.pairs.values;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    // The energies' quotient of the same vector: what differs is rounding, as on very thin bodies.
    const double value = modes.eigenvalues[k] / scales.eigenvalue();
    const auto near = std::min_element(values.begin(), values.end(), [value](double a, double b) {
      return std::abs(a - value) < std::abs(b - value);
    });
    const auto pair = static_cast<std::size_t>(near - values.begin());
    if (!(ritz.lower[pair] > 0)) return std::nullopt;
    const double added =
        0.5 * std::max(core::cents(value / ritz.lower[pair]), std::abs(core::cents(value / *near)));
    error = std::max(error, added);
    if (ritz.truth.empty()) continue;
    auto truth = ritz.truth[pair];
    truth.found *= unit;
    truth.eigenvalue *= unit;
    truth.likely *= unit;
    truth.added = added;
    out.truth.push_back(truth);
  }
  if (error > largest_basis_error) return std::nullopt;
  // Complete as far as the set goes, or not at all.
  const bool limited = ritz.found.flexible_below_top > static_cast<std::int64_t>(modes.size());
  const double known_to = scales.to_frequency(ritz.found.verified_below);
  const bool proved = limited ? modes.size() > 0 && known_to > modes.frequency(modes.size() - 1)
                              : ritz.found.all_verified;
  if (!proved) return std::nullopt;

  modes = modes::rescale(modes, 1, own.youngs_modulus / basis.regions[0].youngs_modulus,
                         own.density / basis.regions[0].density);
  modes.certificate.min_frequency = request.band.min_frequency;
  modes.certificate.max_frequency = request.band.max_frequency;
  if (modes.certificate.complete) {
    modes.certificate.complete_to_hz = request.band.max_frequency;
  }
  modes.certificate.snapshots = static_cast<int>(basis.snapshots.size());
  modes.certificate.basis_error = error;
  return out;
}

/// A group's requests from one basis, of a class of fields on a part or of all on a body.
std::vector<std::optional<eigen::ClassModes>> serve(
    const mesh::TetMesh& mesh, std::span<const ModeRequest> requests, const SolveGroup& group,
    const eigen::SolveOptions& options, const assembly::MirrorClass& mirror,
    const eigen::ErrorMargins* margins, MPI_Comm comm, core::Trace& trace) {
  std::vector<std::optional<eigen::ClassModes>> served(group.requests.size());
  if (eigen::too_small_to_split(mesh, comm)) {
    mpi::agreed_in_group(comm, [&] {
      served = serve(mesh, requests, group, options, mirror, margins, MPI_COMM_SELF, trace);
    });
    return served;
  }
  // Solved in the material of the slowest waves, the last of the group.
  const auto& solved = requests[group.requests.back()].regions;
  auto joint = options;
  joint.band = snapshot_band(requests, group, solved);
  const auto basis =
      make_poisson_basis(mesh, solved, group.snapshots, joint, mirror, margins, comm, trace);
  for (std::size_t k = 0; k < served.size() && basis; ++k) {
    const core::ScopedTimer timer(trace.stages["ritz"]);
    served[k] = from_basis(mesh, *basis, requests[group.requests[k]], comm);
  }
  return served;
}

/// The same of a body by its mirror planes.
std::vector<std::optional<modes::Modes>> serve_by_classes(const mesh::TetMesh& mesh,
                                                          const eigen::PartToSolve& body,
                                                          std::span<const ModeRequest> requests,
                                                          const SolveGroup& group,
                                                          const eigen::SolveOptions& options,
                                                          MPI_Comm comm, core::Trace& trace) {
  std::vector<modes::Band> bands;
  for (const auto i : group.requests) bands.push_back(requests[i].band);
  const eigen::SolveClass solve = [&](const assembly::MirrorClass& mirror,
                                      std::span<const modes::Band> asked,
                                      const eigen::SolveOptions& limits, MPI_Comm of_class) {
    std::vector<ModeRequest> own(requests.begin(), requests.end());
    for (std::size_t k = 0; k < asked.size(); ++k) own[group.requests[k]].band = asked[k];
    return serve(body.part.mesh, own, group, limits, mirror, &body.margins, of_class, trace);
  };
  return eigen::solve_classes(mesh, body, bands, options, solve, comm);
}

/// Modes of all requests of a group that shares a basis.
std::vector<modes::Modes> solve_together(const mesh::TetMesh& mesh,
                                         std::span<const ModeRequest> requests,
                                         const SolveGroup& group,
                                         const eigen::SolveOptions& options, MPI_Comm comm,
                                         core::Trace& trace) {
  std::optional<eigen::PartToSolve> body;
  for (const auto i : group.requests) {
    mpi::agreed_in_group(comm,
                         [&] { eigen::check_input(mesh, requests[i].regions, requests[i].band); });
  }
  mpi::agreed_in_group(comm, [&] {
    body = eigen::part_to_solve(mesh, requests[group.requests.front()].regions, options,
                                mpi::size(comm));
  });
  std::vector<std::optional<modes::Modes>> served;
  if (body) {
    served = serve_by_classes(mesh, *body, requests, group, options, comm, trace);
  } else {
    for (auto& whole : serve(mesh, requests, group, options, {}, nullptr, comm, trace)) {
      auto& one = served.emplace_back();
      if (!whole) continue;
      one = std::move(whole->modes);
      if (!whole->truth.empty())
        one->pitch_errors = eigen::pitch_errors(one->eigenvalues, std::move(whole->truth));
    }
  }
  std::vector<modes::Modes> out;
  for (std::size_t k = 0; k < served.size(); ++k) {
    if (served[k]) {
      out.push_back(std::move(*served[k]));
      continue;
    }
    ++trace.stages["solved apart"].calls;
    auto own = options;
    own.band = requests[group.requests[k]].band;
    out.push_back(eigen::solve_modes(mesh, requests[group.requests[k]].regions, own, comm, trace));
  }
  return out;
}

/// Keys of a group's sets: a set depends on all that it was solved with.
std::vector<std::string> keys_of(const mesh::TetMesh& mesh, std::span<const ModeRequest> requests,
                                 const SolveGroup& group, const eigen::SolveOptions& options,
                                 MPI_Comm comm) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  std::vector<std::string> own;
  core::Sha256 all;
  all.add("joint modes 1 ");
  all.add(std::span<const double>(group.snapshots));
  for (const auto i : group.requests) {
    auto one = options;
    one.band = requests[i].band;
    own.push_back(eigen::modes_key(mesh, requests[i].regions, one, size));
    all.add(own.back());
  }
  const auto together = all.hex();
  std::vector<std::string> keys;
  for (const auto& key : own) {
    core::Sha256 hash;
    keys.push_back(hash.add(together).add(key).hex());
  }
  return keys;
}

std::vector<modes::Modes> cached_together(const mesh::TetMesh& mesh,
                                          std::span<const ModeRequest> requests,
                                          const SolveGroup& group,
                                          const eigen::SolveOptions& options, MPI_Comm comm,
                                          const std::filesystem::path& cache, core::Trace& trace) {
  if (cache.empty()) return solve_together(mesh, requests, group, options, comm, trace);
  const auto keys = keys_of(mesh, requests, group, options, comm);
  std::vector<modes::Modes> modes;
  for (const auto& key : keys) {
    auto stored = eigen::load_modes(cache, key, comm, trace);
    if (!stored) break;
    modes.push_back(std::move(*stored));
  }
  if (modes.size() == keys.size()) return modes;
  modes = solve_together(mesh, requests, group, options, comm, trace);
  for (std::size_t k = 0; k < keys.size(); ++k) eigen::store_modes(cache, keys[k], modes[k], comm);
  return modes;
}

}  // namespace

std::vector<modes::Modes> solve_materials(const mesh::TetMesh& mesh,
                                          std::span<const ModeRequest> requests,
                                          const eigen::SolveOptions& options, MPI_Comm comm,
                                          const std::filesystem::path& cache, core::Trace& trace) {
  if (mesh.faces.empty() && mesh.element_count() > 0) {
    mesh::TetMesh bounded = mesh;
    bounded.faces = mesh::boundary_faces(mesh);
    return solve_materials(bounded, requests, options, comm, cache, trace);
  }
  std::vector<modes::Modes> out(requests.size());
  for (const auto& group : plan_solves(mesh, requests)) {
    if (!group.snapshots.empty()) {
      auto modes = cached_together(mesh, requests, group, options, comm, cache, trace);
      for (std::size_t k = 0; k < modes.size(); ++k) {
        out[group.requests[k]] = std::move(modes[k]);
      }
      continue;
    }
    for (const auto i : group.requests) {
      auto own = options;
      own.band = requests[i].band;
      out[i] = eigen::cached_modes(mesh, requests[i].regions, own, comm, cache, trace);
    }
  }
  return out;
}

}  // namespace carillon::solvers::basis
