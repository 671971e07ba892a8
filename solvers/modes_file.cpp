#include "solvers/modes_file.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <optional>
#include <utility>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "solvers/library_versions.hpp"
#include "solvers/modes_broadcast.hpp"

namespace carillon::solvers {
namespace {

/// Part of every key: raise it when solve_modes() gives other values for equal input.
constexpr std::string_view solver_version = "carillon modes 5";
/// Of the layout in a file.
constexpr std::int64_t format_version = 4;

constexpr int deflate_level = 4;

using core::Hdf5Group;

/// Rows of shapes are read one mode at a time, so a chunk is one row.
core::StorageOptions compressed_rows(std::uint64_t rows) {
  return rows == 0 ? core::StorageOptions{} : core::StorageOptions{1, deflate_level};
}

void write_matrix(const Hdf5Group& group, const std::string& name, const Eigen::MatrixXd& matrix) {
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows = matrix;
  group.write<double>(
      name, {rows.data(), static_cast<std::size_t>(rows.size())},
      {static_cast<std::uint64_t>(rows.rows()), static_cast<std::uint64_t>(rows.cols())});
  group.write_attribute("unit", std::string("1"), name);
}

Eigen::MatrixXd read_matrix(const Hdf5Group& group, const std::string& name) {
  const auto extent = group.extent(name);
  const auto values = group.read<double>(name);
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const Rows>(values.data(), static_cast<Eigen::Index>(extent.at(0)),
                                static_cast<Eigen::Index>(extent.at(1)));
}

void write_certificate(const Hdf5Group& group, const Certificate& c) {
  const auto integer = [&group](const char* name, std::int64_t value) {
    group.write_attribute(name, value);
  };
  group.write_attribute("min_frequency_hz", c.min_frequency);
  group.write_attribute("max_frequency_hz", c.max_frequency);
  integer("modes_in_band", c.modes_in_band);
  integer("modes_found", c.modes_found);
  integer("complete", c.complete ? 1 : 0);
  group.write_attribute("complete_to_hz", c.complete_to_hz);
  integer("rigid_modes", c.rigid_modes);
  integer("components", c.components);
  group.write_attribute("max_residual", c.max_residual);
  group.write_attribute("orthonormality", c.orthonormality);
  integer("unknowns", c.unknowns);
  integer("count_verified", c.count_verified ? 1 : 0);
  group.write_attribute("eigen_solver", std::string(name_of(c.eigen_solver)));
  group.write_attribute("linear_solver", std::string(name_of(c.linear_solver)));
  integer("snapshots", c.snapshots);
  group.write_attribute("basis_error_cents", c.basis_error);
}

Certificate read_certificate(const Hdf5Group& group) {
  const auto number = [&group](const char* name) { return group.number_attribute(name); };
  const auto integer = [&number](const char* name) {
    return static_cast<std::int64_t>(number(name));
  };
  Certificate c;
  c.min_frequency = number("min_frequency_hz");
  c.max_frequency = number("max_frequency_hz");
  c.modes_in_band = integer("modes_in_band");
  c.modes_found = integer("modes_found");
  c.complete = integer("complete") != 0;
  c.complete_to_hz = number("complete_to_hz");
  c.rigid_modes = static_cast<int>(integer("rigid_modes"));
  c.components = static_cast<int>(integer("components"));
  c.max_residual = number("max_residual");
  c.orthonormality = number("orthonormality");
  c.unknowns = integer("unknowns");
  c.count_verified = integer("count_verified") != 0;
  c.eigen_solver = parse_eigen_solver(group.text_attribute("eigen_solver"));
  c.linear_solver = group.text_attribute("linear_solver") == name_of(LinearSolver::iterative)
                        ? LinearSolver::iterative
                        : LinearSolver::direct;
  c.snapshots = static_cast<int>(integer("snapshots"));
  c.basis_error = number("basis_error_cents");
  return c;
}

void write_surface(const Hdf5Group& group, const ModeSurface& surface) {
  std::vector<double> nodes;
  for (const auto& x : surface.nodes) nodes.insert(nodes.end(), x.begin(), x.end());
  group.write<double>("nodes", nodes, {surface.nodes.size(), 3});
  group.write_attribute("unit", std::string("m"), "nodes");
  const auto per_face = static_cast<std::uint64_t>(nodes_per_face(surface.order));
  group.write<std::int32_t>("faces", surface.faces, {surface.faces.size() / per_face, per_face});
  group.write_attribute("order", static_cast<std::int64_t>(surface.order));
}

std::filesystem::path file_of(const std::filesystem::path& cache, const std::string& key) {
  return cache / (key + ".h5");
}

/// A cached set, unless there is none or the file is unusable.
std::optional<Modes> load(const std::filesystem::path& path) {
  try {
    if (!std::filesystem::exists(path)) return std::nullopt;
    return read_modes(Hdf5Group::open_file(path));
  } catch (const std::exception& e) {
    spdlog::warn("cached modes are solved again: {}", e.what());
    return std::nullopt;
  }
}

void store(const std::filesystem::path& path, const Modes& modes) {
  try {
    core::write_durably(path, [&modes](const std::filesystem::path& temporary) {
      write_modes(Hdf5Group::create_file(temporary), modes);
    });
  } catch (const std::exception& e) {
    // The modes themselves are good; only the next run is slower.
    spdlog::warn("modes could not be cached: {}", e.what());
  }
}

}  // namespace

void write_modes(const Hdf5Group& group, const Modes& modes) {
  const std::uint64_t count = modes.size();
  group.write_attribute("format_version", format_version);
  group.write<double>("eigenvalues", modes.eigenvalues, {count});
  group.write_attribute("unit", std::string("rad^2/s^2"), "eigenvalues");
  group.write<double>("residuals", modes.residuals, {count});
  group.write_attribute("unit", std::string("1"), "residuals");
  if (!modes.pitch_errors.empty()) {
    group.write<double>("pitch_errors", modes.pitch_errors, {count});
    group.write_attribute("unit", std::string("cent"), "pitch_errors");
  }
  if (!modes.harmonics.empty()) group.write<std::int32_t>("harmonics", modes.harmonics, {count});
  const core::Extent shape = {count, modes.surface.nodes.size(), 3};
  group.write<float>("shapes", {modes.shapes.data(), static_cast<std::size_t>(modes.shapes.size())},
                     shape, compressed_rows(count));
  group.write_attribute("unit", std::string("kg^-1/2"), "shapes");
  write_matrix(group, "kinetic_share", modes.kinetic_share);
  write_matrix(group, "strain_share", modes.strain_share);
  write_surface(group.create_group("surface"), modes.surface);
  group.write_attribute("mass_kg", modes.mass);
  write_certificate(group.create_group("certificate"), modes.certificate);
}

ModeSurface read_mode_surface(const Hdf5Group& set) {
  const Hdf5Group group = set.open_group("surface");
  ModeSurface surface;
  surface.order = static_cast<int>(group.number_attribute("order"));
  const auto nodes = group.read<double>("nodes");
  for (std::size_t n = 0; n + 2 < nodes.size(); n += 3) {
    surface.nodes.emplace_back(nodes[n], nodes[n + 1], nodes[n + 2]);
  }
  surface.faces = group.read<std::int32_t>("faces");
  return surface;
}

Modes read_modes(const Hdf5Group& group) {
  if (group.number_attribute("format_version") != static_cast<double>(format_version)) {
    throw core::FileError("the modes were written by another version of the format");
  }
  Modes modes;
  modes.eigenvalues = group.read<double>("eigenvalues");
  modes.residuals = group.read<double>("residuals");
  if (group.has("pitch_errors")) modes.pitch_errors = group.read<double>("pitch_errors");
  if (group.has("harmonics")) modes.harmonics = group.read<std::int32_t>("harmonics");
  modes.surface = read_mode_surface(group);
  const auto shapes = group.read<float>("shapes");
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  modes.shapes = Eigen::Map<const Rows>(shapes.data(), static_cast<Eigen::Index>(modes.size()),
                                        3 * static_cast<Eigen::Index>(modes.surface.nodes.size()));
  modes.kinetic_share = read_matrix(group, "kinetic_share");
  modes.strain_share = read_matrix(group, "strain_share");
  modes.mass = group.number_attribute("mass_kg");
  modes.certificate = read_certificate(group.open_group("certificate"));
  return modes;
}

std::string modes_key(const TetMesh& mesh, std::span<const Elastic> regions,
                      const SolveOptions& options, int group_size) {
  core::Sha256 hash;
  hash.add(solver_version);
  for (const auto& [library, version] : library_versions()) {
    hash.add(fmt::format(" {} {}", library, version));
  }
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
    numbers.insert(numbers.end(), {region.youngs_modulus, region.poisson_ratio, region.density});
  }
  numbers.insert(
      numbers.end(),
      {options.band.min_frequency, options.band.max_frequency,
       static_cast<double>(options.band.max_modes), options.band.counted_from, options.tolerance,
       static_cast<double>(options.solver), static_cast<double>(options.linear_solver),
       static_cast<double>(options.memory_limit), options.estimate_errors ? 1.0 : 0.0});
  hash.add(std::span<const double>(numbers));
  return hash.hex();
}

std::optional<Modes> load_modes(const std::filesystem::path& cache, const std::string& key,
                                MPI_Comm comm, core::Trace& trace) {
  const double start = core::monotonic_seconds();
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::optional<Modes> modes;
  if (rank == 0) modes = load(file_of(cache, key));
  int hit = modes ? 1 : 0;
  MPI_Bcast(&hit, 1, MPI_INT, 0, comm);
  if (!hit) return std::nullopt;
  if (!modes) modes.emplace();
  broadcast(*modes, comm);
  auto& entry = trace.stages["modes from cache"];
  ++entry.calls;
  entry.seconds += core::monotonic_seconds() - start;
  return modes;
}

void store_modes(const std::filesystem::path& cache, const std::string& key, const Modes& modes,
                 MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  if (rank == 0) store(file_of(cache, key), modes);
}

Modes cached_modes(const TetMesh& mesh, std::span<const Elastic> regions,
                   const SolveOptions& options, MPI_Comm comm, const std::filesystem::path& cache,
                   core::Trace& trace) {
  if (cache.empty()) return solve_modes(mesh, regions, options, comm, trace);
  int size = 1;
  MPI_Comm_size(comm, &size);
  const auto key = modes_key(mesh, regions, options, size);
  if (auto modes = load_modes(cache, key, comm, trace)) return std::move(*modes);
  auto modes = solve_modes(mesh, regions, options, comm, trace);
  store_modes(cache, key, modes, comm);
  return modes;
}

}  // namespace carillon::solvers
