#include "solvers/modes/modes_file.hpp"

#include <fmt/core.h>

#include <utility>

#include "core/error.hpp"

namespace carillon::solvers::modes {
namespace {

/// Of the layout in a file.
constexpr std::int64_t format_version = 7;

/// Shapes are noise to zlib: more effort saves little room and takes as long as their solve.
constexpr int deflate_level = 1;

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
  integer("mirror_planes", c.mirror_planes);
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
  c.mirror_planes = static_cast<int>(integer("mirror_planes"));
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
  const auto per_face = static_cast<std::uint64_t>(elements::nodes_per_face(surface.order));
  group.write<std::int32_t>("faces", surface.faces, {surface.faces.size() / per_face, per_face});
  group.write_attribute("order", static_cast<std::int64_t>(surface.order));
}

/// Shapes at nodes as they are, those of a body of revolution by its rings.
void write_shapes(const Hdf5Group& group, const ModeShapes& shapes) {
  const ModeShapes::Rows& values = shapes.values();
  const auto count = static_cast<std::uint64_t>(values.rows());
  const bool on_rings = !shapes.rings().empty();
  const std::string name = on_rings ? "ring_amplitudes" : "shapes";
  group.write<float>(name, {values.data(), static_cast<std::size_t>(values.size())},
                     {count, static_cast<std::uint64_t>(values.cols()) / 3, 3},
                     compressed_rows(count));
  group.write_attribute("unit", std::string("kg^-1/2"), name);
  if (!on_rings) return;
  std::vector<std::int32_t> rings, harmonics, turned;
  for (const NodeRing& ring : shapes.rings()) rings.insert(rings.end(), {ring.first, ring.around});
  for (const CircumferentialWave& wave : shapes.waves()) {
    harmonics.push_back(wave.harmonic);
    turned.push_back(wave.turned);
  }
  group.write<std::int32_t>("rings", rings, {shapes.rings().size(), 2});
  group.write<std::int32_t>("harmonics", harmonics, {count});
  group.write<std::int32_t>("turned", turned, {count});
}

ModeShapes read_shapes(const Hdf5Group& group, Eigen::Index modes) {
  const bool on_rings = group.has("rings");
  const std::string name = on_rings ? "ring_amplitudes" : "shapes";
  const auto columns = 3 * static_cast<Eigen::Index>(group.extent(name).at(1));
  const auto values = group.read<float>(name);
  ModeShapes::Rows rows = Eigen::Map<const ModeShapes::Rows>(values.data(), modes, columns);
  if (!on_rings) return ModeShapes(std::move(rows));
  const auto places = group.read<std::int32_t>("rings");
  const auto harmonics = group.read<std::int32_t>("harmonics");
  const auto turned = group.read<std::int32_t>("turned");
  std::vector<NodeRing> rings;
  for (std::size_t r = 0; r + 1 < places.size(); r += 2)
    rings.push_back({places[r], places[r + 1]});
  std::vector<CircumferentialWave> waves;
  for (std::size_t k = 0; k < harmonics.size(); ++k) waves.push_back({harmonics[k], turned.at(k)});
  return ModeShapes(std::move(rows), std::move(rings), std::move(waves));
}

}  // namespace

void write_modes(const Hdf5Group& group, const Modes& modes) {
  const std::uint64_t count = modes.size();
  group.write_attribute("format_version", format_version);
  group.write<double>("eigenvalues", modes.eigenvalues, {count});
  group.write_attribute("unit", std::string("rad^2/s^2"), "eigenvalues");
  group.write<double>("residuals", modes.residuals, {count});
  group.write_attribute("unit", std::string("1"), "residuals");
  if (!modes.given_decay_rates.empty()) {
    group.write<double>("given_decay_rates", modes.given_decay_rates, {count});
    group.write_attribute("unit", std::string("1/s"), "given_decay_rates");
  }
  if (!modes.pitch_errors.empty()) {
    group.write<double>("pitch_errors", modes.pitch_errors, {count});
    group.write_attribute("unit", std::string("cent"), "pitch_errors");
  }
  write_shapes(group, modes.shapes);
  write_matrix(group, "kinetic_fraction", modes.kinetic_fraction);
  write_matrix(group, "strain_fraction", modes.strain_fraction);
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
  if (group.has("given_decay_rates"))
    modes.given_decay_rates = group.read<double>("given_decay_rates");
  if (group.has("pitch_errors")) modes.pitch_errors = group.read<double>("pitch_errors");
  modes.surface = read_mode_surface(group);
  modes.shapes = read_shapes(group, static_cast<Eigen::Index>(modes.size()));
  modes.kinetic_fraction = read_matrix(group, "kinetic_fraction");
  modes.strain_fraction = read_matrix(group, "strain_fraction");
  modes.mass = group.number_attribute("mass_kg");
  modes.certificate = read_certificate(group.open_group("certificate"));
  return modes;
}

}  // namespace carillon::solvers::modes
