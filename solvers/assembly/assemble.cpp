#include "solvers/assembly/assemble.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "mpi/comm.hpp"

namespace carillon::solvers::assembly {
namespace {

[[noreturn]] void refuse_element(const mesh::TetMesh& mesh, std::size_t e) {
  Vec3 middle = Vec3::Zero();
  for (const auto n : mesh.element(e).first(4)) {
    middle += mesh.nodes[static_cast<std::size_t>(n)] / 4;
  }
  throw core::SolverError(
      fmt::format("element {} near ({:.4g}, {:.4g}, {:.4g}) m is turned inside out or flat: its "
                  "Jacobian is not positive",
                  e, middle[0], middle[1], middle[2]),
      "straighten its curved sides, or mesh the object again with another element size");
}

/// Cuts off what the class holds.
void hold_unknowns(const mesh::TetMesh& mesh, System& system) {
  const auto& graph = system.graph;
  for (const auto node : system.partition.node)
    system.held.push_back(system.mirror.held_at(mesh.nodes[static_cast<std::size_t>(node)]));
  for (std::int32_t row = 0; row < graph.rows(); ++row) {
    const auto begin = graph.first[static_cast<std::size_t>(row)];
    const auto width = graph.first[static_cast<std::size_t>(row) + 1] - begin;
    for (std::int64_t k = 0; k < width; ++k) {
      const auto column = graph.column[static_cast<std::size_t>(begin + k)];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          const bool is_diagonal = column == graph.begin + row && i == j;
          if (is_diagonal || (!system.is_held(graph.begin + row, i) && !system.is_held(column, j)))
            continue;
          system.stiffness[static_cast<std::size_t>(9 * begin + (i * width + k) * 3 + j)] = 0;
        }
      }
    }
  }
}

}  // namespace

std::int64_t System::free_unknowns() const {
  std::int64_t count = unknowns();
  for (const auto bits : held) count -= std::popcount(bits);
  return count;
}

void hold(const System& system, Eigen::Ref<Eigen::MatrixXd> fields) {
  if (system.held.empty()) return;
  for (std::int32_t row = 0; row < system.graph.rows(); ++row) {
    for (int i = 0; i < 3; ++i) {
      if (system.is_held(system.graph.begin + row, i)) fields.row(3 * row + i).setZero();
    }
  }
}

double Scales::from_frequency(double hertz) const {
  const double omega = 2 * std::numbers::pi * hertz;
  return omega * omega / eigenvalue();
}

double Scales::to_frequency(double value) const {
  return std::sqrt(std::max(0.0, value * eigenvalue())) / (2 * std::numbers::pi);
}

Scales scales_of(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions) {
  Scales scales;
  const auto box = mesh::bounding_box(mesh.nodes);
  scales.length = box.longest_side();
  scales.origin = (box.low + box.high) / 2;
  scales.modulus = scales.density = 0;
  for (const auto& region : regions) {
    scales.modulus = std::max(scales.modulus, region.youngs_modulus);
    scales.density = std::max(scales.density, region.density);
  }
  return scales;
}

std::vector<elements::ElasticConstants> elastic_constants(
    std::span<const elements::Elastic> regions, const Scales& scales) {
  std::vector<elements::ElasticConstants> out;
  for (const auto& region : regions) {
    out.push_back(elements::isotropic_constants(region.youngs_modulus / scales.modulus,
                                                region.poisson_ratio,
                                                region.density / scales.density));
    if (region.anisotropy)
      out.back().stiffness = region.youngs_modulus / scales.modulus * *region.anisotropy;
  }
  return out;
}

void gather(const mesh::TetMesh& mesh, std::size_t e, const Scales& scales,
            elements::Coordinates& nodes) {
  const auto element = mesh.element(e);
  nodes.resize(3, static_cast<Eigen::Index>(element.size()));
  for (std::size_t n = 0; n < element.size(); ++n) {
    nodes.col(static_cast<Eigen::Index>(n)) =
        (mesh.nodes[static_cast<std::size_t>(element[n])] - scales.origin) / scales.length;
  }
}

System empty_system(const mesh::TetMesh& mesh, const Scales& scales, Partition part,
                    MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  System system;
  system.scales = scales;
  system.partition = std::move(part);
  system.graph = node_graph(mesh, system.partition, elements_around_nodes(mesh), rank);
  system.stiffness.assign(9 * system.graph.column.size(), 0.0);
  system.mass.assign(system.graph.column.size(), 0.0);
  return system;
}

std::vector<std::size_t> elements_of_rank(const mesh::TetMesh& mesh, const System& system) {
  std::vector<std::size_t> out;
  const auto begin = system.graph.begin, end = begin + system.graph.rows();
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    if (std::any_of(element.begin(), element.end(), [&](std::int32_t n) {
          const auto number = system.partition.number[static_cast<std::size_t>(n)];
          return number >= begin && number < end;
        })) {
      out.push_back(e);
    }
  }
  return out;
}

void add_element(std::span<const std::int32_t> element, const Eigen::MatrixXd& k,
                 const Eigen::MatrixXd& m, System& system) {
  const auto& graph = system.graph;
  const auto nodes = static_cast<Eigen::Index>(element.size());
  const auto number = [&](Eigen::Index local) {
    const auto node = element[static_cast<std::size_t>(local)];
    return system.partition.number[static_cast<std::size_t>(node)];
  };
  for (Eigen::Index a = 0; a < nodes; ++a) {
    const auto row = number(a) - graph.begin;
    if (row < 0 || row >= graph.rows()) continue;
    const auto first = graph.first[static_cast<std::size_t>(row)];
    const auto width = graph.first[static_cast<std::size_t>(row) + 1] - first;
    const auto* columns = graph.column.data() + first;
    double* const block_row = system.stiffness.data() + 9 * first;
    double* const mass_row = system.mass.data() + first;
    for (Eigen::Index b = 0; b < nodes; ++b) {
      const auto at = std::lower_bound(columns, columns + width, number(b)) - columns;
      mass_row[at] += m(a, b);
      for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) {
          block_row[3 * (i * width + at) + j] += k(3 * a + i, 3 * b + j);
        }
      }
    }
  }
}

System assemble(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                Partition part, MPI_Comm comm, const MirrorClass& mirror) {
  System system;
  mpi::agreed_in_group(comm, [&] {
    system = empty_system(mesh, scales_of(mesh, regions), std::move(part), comm);
    system.mirror = mirror;
    const auto constants = elastic_constants(regions, system.scales);
    elements::ElementKernel kernel(mesh.order);
    elements::Coordinates nodes;
    Eigen::MatrixXd k, m;
    for (const auto e : elements_of_rank(mesh, system)) {
      gather(mesh, e, system.scales, nodes);
      if (!(kernel.place(nodes) > 0)) refuse_element(mesh, e);
      const auto& material = constants[static_cast<std::size_t>(mesh.regions[e])];
      kernel.stiffness(material, k);
      kernel.mass(material.density, m);
      add_element(mesh.element(e), k, m, system);
    }
    if (!mirror.planes.empty()) hold_unknowns(mesh, system);
  });
  return system;
}

}  // namespace carillon::solvers::assembly
