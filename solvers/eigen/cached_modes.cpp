#include "solvers/eigen/cached_modes.hpp"

#include <fmt/core.h>

#include <utility>

#include "core/cached.hpp"
#include "core/hash.hpp"
#include "solvers/libraries/environment.hpp"
#include "solvers/libraries/library_versions.hpp"
#include "solvers/modes/modes_broadcast.hpp"
#include "solvers/modes/modes_file.hpp"

namespace carillon::solvers::eigen {
namespace {

/// Part of every key: raise it when solve_modes() gives other values for equal input, or files of
/// modes another layout.
constexpr std::string_view solver_version = "carillon modes 15";

std::filesystem::path file_of(const std::filesystem::path& cache, const std::string& key) {
  return cache / (key + ".h5");
}

}  // namespace

std::string modes_key(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                      const SolveOptions& options, int group_size) {
  core::Sha256 hash;
  hash.add(solver_version);
  for (const auto& [library, version] : libraries::library_versions()) {
    hash.add(fmt::format(" {} {}", library, version));
  }
  hash.add(libraries::solver_options());
  const auto header = fmt::format("order {} nodes {} elements {} faces {} regions {} group {} ",
                                  mesh.order, mesh.nodes.size(), mesh.element_count(),
                                  mesh.face_count(), regions.size(), group_size);
  hash.add(header);
  for (const auto& x : mesh.nodes) hash.add(std::span<const double>(x.data(), 3));
  for (const auto* points : {&mesh.finer_nodes, &mesh.finer_gaps}) {
    for (const auto& x : *points) hash.add(std::span<const double>(x.data(), 3));
  }
  hash.add(std::span<const std::int32_t>(mesh.elements));
  hash.add(std::span<const std::int32_t>(mesh.regions));
  hash.add(std::span<const std::int32_t>(mesh.faces));
  std::vector<double> numbers;
  for (const auto& region : regions) {
    const std::vector<double> own = elements::identity_of(region);
    numbers.insert(numbers.end(), own.begin(), own.end());
  }
  numbers.insert(
      numbers.end(),
      {options.band.min_frequency, options.band.max_frequency,
       static_cast<double>(options.band.max_modes), options.band.counted_from, options.tolerance,
       static_cast<double>(options.solver), static_cast<double>(options.linear_solver),
       static_cast<double>(options.memory_limit), options.estimate_errors ? 1.0 : 0.0,
       options.mirror_planes ? 1.0 : 0.0});
  hash.add(std::span<const double>(numbers));
  return hash.hex();
}

std::optional<modes::Modes> load_modes(const std::filesystem::path& cache, const std::string& key,
                                       MPI_Comm comm, core::Trace& trace) {
  const double start = core::monotonic_seconds();
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::optional<modes::Modes> modes;
  if (rank == 0) {
    modes = core::from_cache<modes::Modes>(file_of(cache, key), [](const auto& path) {
      return modes::read_modes(core::Hdf5Group::open_file(path));
    });
  }
  int hit = modes ? 1 : 0;
  MPI_Bcast(&hit, 1, MPI_INT, 0, comm);
  if (!hit) return std::nullopt;
  if (!modes) modes.emplace();
  modes::broadcast(*modes, comm);
  auto& entry = trace.stages["modes from cache"];
  ++entry.calls;
  entry.seconds += core::monotonic_seconds() - start;
  return modes;
}

void store_modes(const std::filesystem::path& cache, const std::string& key,
                 const modes::Modes& modes, MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  if (rank != 0) return;
  core::to_cache(file_of(cache, key), [&](const std::filesystem::path& path) {
    modes::write_modes(core::Hdf5Group::create_file(path), modes);
  });
}

modes::Modes cached_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                          const SolveOptions& options, MPI_Comm comm,
                          const std::filesystem::path& cache, core::Trace& trace) {
  if (cache.empty()) return solve_modes(mesh, regions, options, comm, trace);
  int size = 1;
  MPI_Comm_size(comm, &size);
  const auto key = modes_key(mesh, regions, options, size);
  if (auto modes = load_modes(cache, key, comm, trace)) return std::move(*modes);
  auto modes = solve_modes(mesh, regions, options, comm, trace);
  store_modes(cache, key, modes, comm);
  return modes;
}

}  // namespace carillon::solvers::eigen
