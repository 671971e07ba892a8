#include "solvers/eigen/extract.hpp"

#include <algorithm>
#include <cmath>

#include "mpi/comm.hpp"
#include "solvers/assembly/fields.hpp"

namespace carillon::solvers::eigen {
namespace {

/// Modes treated at a time: bounds the copy of whole shapes that every rank holds.
constexpr std::size_t batch_size = 32;

Eigen::MatrixXd columns_of(const EigenPairs& pairs, std::span<const std::size_t> chosen) {
  Eigen::MatrixXd out(pairs.vectors.rows(), static_cast<Eigen::Index>(chosen.size()));
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    out.col(static_cast<Eigen::Index>(k)) = pairs.vectors.col(static_cast<Eigen::Index>(chosen[k]));
  }
  return out;
}

/// Adds the energies of the elements whose first node this rank owns.
/// @param strain, kinetic  modes x regions
void add_energies(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                  const assembly::System& system, const assembly::NodeFields& fields,
                  Eigen::Ref<Eigen::ArrayXXd> strain, Eigen::Ref<Eigen::ArrayXXd> kinetic) {
  const auto constants = assembly::elastic_constants(regions, system.scales);
  elements::ElementKernel kernel(mesh.order);
  elements::Coordinates nodes;
  Eigen::MatrixXd u(kernel.nodes(), fields.cols());
  const auto begin = system.graph.begin, end = begin + system.graph.rows();
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    const auto number = [&](std::size_t n) {
      return system.partition.number[static_cast<std::size_t>(element[n])];
    };
    if (number(0) < begin || number(0) >= end) continue;
    assembly::gather(mesh, e, system.scales, nodes);
    kernel.place(nodes);
    for (std::size_t n = 0; n < element.size(); ++n) {
      u.row(static_cast<Eigen::Index>(n)) = fields.row(number(n));
    }
    const auto region = mesh.regions[e];
    kernel.add_energies(constants[static_cast<std::size_t>(region)], u, strain.col(region),
                        kinetic.col(region));
  }
}

/// A shape's displacements at the surface nodes, signed and in kg^-1/2.
void keep_surface(const assembly::System& system, const assembly::NodeFields& fields,
                  Eigen::Index field, std::span<const std::int32_t> surface_nodes, double scale,
                  float* out) {
  Eigen::VectorXd values(3 * static_cast<Eigen::Index>(surface_nodes.size()));
  for (std::size_t n = 0; n < surface_nodes.size(); ++n) {
    const auto number = system.partition.number[static_cast<std::size_t>(surface_nodes[n])];
    values.segment<3>(3 * static_cast<Eigen::Index>(n)) =
        fields.block<1, 3>(number, 3 * field).transpose();
  }
  scale *= leading_sign(values);
  Eigen::Map<Eigen::VectorXf>(out, values.size()) = (scale * values).cast<float>();
}

}  // namespace

double leading_sign(const Eigen::Ref<const Eigen::VectorXd>& shape) {
  if (shape.size() == 0) return 1;
  const double largest = shape.cwiseAbs().maxCoeff();
  const auto leading = std::find_if(shape.begin(), shape.end(), [largest](double v) {
    return std::abs(v) >= (1 - 1e-6) * largest;
  });
  return leading != shape.end() && *leading < 0 ? -1 : 1;
}

modes::ModeSurface surface_of(const mesh::TetMesh& mesh, std::vector<std::int32_t>& nodes) {
  modes::ModeSurface surface;
  surface.order = mesh.order;
  nodes.assign(mesh.faces.begin(), mesh.faces.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  std::vector<std::int32_t> place(mesh.nodes.size(), -1);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const auto node = static_cast<std::size_t>(nodes[k]);
    place[node] = static_cast<std::int32_t>(k);
    surface.nodes.push_back(mesh.nodes[node]);
  }
  for (const auto node : mesh.faces) {
    surface.faces.push_back(place[static_cast<std::size_t>(node)]);
  }
  return surface;
}

ModeFields extract_fields(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                          const assembly::System& system, const EigenPairs& pairs,
                          std::span<const std::size_t> chosen,
                          std::span<const std::int32_t> surface_nodes, MPI_Comm comm) {
  const auto modes = static_cast<Eigen::Index>(chosen.size());
  const auto region_count = static_cast<Eigen::Index>(regions.size());
  Eigen::ArrayXXd strain, kinetic;
  ModeFields out;
  mpi::agreed_in_group(comm, [&] {
    kinetic = strain = Eigen::ArrayXXd::Zero(modes, region_count);
    out.shapes.resize(modes, 3 * static_cast<Eigen::Index>(surface_nodes.size()));
  });
  const auto& scales = system.scales;
  // Dimensionless shapes are normalised by the mass in units of density length^3.
  const double to_si = 1 / std::sqrt(scales.density * std::pow(scales.length, 3));
  for (std::size_t first = 0; first < chosen.size(); first += batch_size) {
    const auto batch = chosen.subspan(first, std::min(batch_size, chosen.size() - first));
    Eigen::MatrixXd columns;
    mpi::agreed_in_group(comm, [&] { columns = columns_of(pairs, batch); });
    const auto fields = assembly::gather_fields(system, columns, comm);
    const auto row = static_cast<Eigen::Index>(first);
    const auto count = static_cast<Eigen::Index>(batch.size());
    mpi::agreed_in_group(comm, [&] {
      add_energies(mesh, regions, system, fields, strain.middleRows(row, count),
                   kinetic.middleRows(row, count));
      for (Eigen::Index f = 0; f < count; ++f) {
        keep_surface(system, fields, f, surface_nodes, to_si, out.shapes.row(row + f).data());
      }
    });
  }
  for (auto* energies : {&strain, &kinetic}) {
    MPI_Allreduce(MPI_IN_PLACE, energies->data(), static_cast<int>(energies->size()), MPI_DOUBLE,
                  MPI_SUM, comm);
  }
  const Eigen::ArrayXd total_strain = strain.rowwise().sum(),
                       total_kinetic = kinetic.rowwise().sum();
  for (Eigen::Index k = 0; k < modes; ++k) {
    out.eigenvalues.push_back(total_strain[k] / total_kinetic[k] * scales.eigenvalue());
  }
  out.strain_fraction = strain.colwise() / total_strain;
  out.kinetic_fraction = kinetic.colwise() / total_kinetic;
  return out;
}

}  // namespace carillon::solvers::eigen
