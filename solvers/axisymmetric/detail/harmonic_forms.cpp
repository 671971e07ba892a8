#include "solvers/axisymmetric/detail/harmonic_forms.hpp"

#include <fmt/core.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.hpp"
#include "solvers/elements/element.hpp"
#include "solvers/elements/lobatto.hpp"
#include "solvers/elements/quadrature.hpp"

namespace carillon::solvers::axisymmetric {
namespace {

using std::numbers::pi;
constexpr int strains = 6;  ///< rr, theta theta, zz, rz, r theta, theta z

/// Shape functions at the points of one quadrature rule of the unit square.
struct SquareTable {
  Eigen::VectorXd weights;
  Eigen::MatrixXd values, by_u, by_v;  ///< points x nodes
};

SquareTable tabulate(int order, const std::vector<std::array<double, 3>>& rule) {
  const auto points = static_cast<Eigen::Index>(rule.size());
  const Eigen::Index side = order + 1;
  SquareTable table{Eigen::VectorXd(points), Eigen::MatrixXd(points, side * side), {}, {}};
  table.by_u = table.by_v = table.values;
  for (Eigen::Index q = 0; q < points; ++q) {
    const auto& [u, v, weight] = rule[static_cast<std::size_t>(q)];
    const auto along = elements::line_shapes(order, u), up = elements::line_shapes(order, v);
    table.weights[q] = weight;
    for (Eigen::Index j = 0; j < side; ++j) {
      const auto at = j * side;
      table.values.row(q).segment(at, side) = up.values[j] * along.values.transpose();
      table.by_u.row(q).segment(at, side) = up.values[j] * along.slopes.transpose();
      table.by_v.row(q).segment(at, side) = up.slopes[j] * along.values.transpose();
    }
  }
  return table;
}

/// Gauss' rule, and four that are collapsed into one corner (Duffy 1982): where a cell meets the
/// axis in a corner alone, 1/r is smooth in polar coordinates about it but not in u and v.
std::array<SquareTable, 5> make_tables(int order) {
  Eigen::VectorXd x, w;
  elements::gauss_jacobi(order + 3, 0, x, w);
  std::array<std::vector<std::array<double, 3>>, 5> rules;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    for (Eigen::Index j = 0; j < x.size(); ++j) {
      rules[0].push_back({x[i], x[j], w[i] * w[j]});
      for (std::size_t corner = 0; corner < 4; ++corner) {
        for (const bool swapped : {false, true}) {
          double u = x[i], v = x[i] * x[j];
          if (swapped) std::swap(u, v);
          if (corner == 1 || corner == 2) u = 1 - u;
          if (corner >= 2) v = 1 - v;
          rules[corner + 1].push_back({u, v, w[i] * w[j] * x[i]});
        }
      }
    }
  }
  std::array<SquareTable, 5> tables;
  for (std::size_t k = 0; k < 5; ++k) tables[k] = tabulate(order, rules[k]);
  return tables;
}

/// What the integrals over one cell need.
struct Cell {
  std::span<const std::int32_t> nodes;
  std::array<Eigen::MatrixXd, 3> slopes;  ///< points x nodes: d/dr, d/dz, 1/r of the functions
  const Eigen::MatrixXd* values;          ///< points x nodes
  Eigen::VectorXd volumes;                ///< weight x determinant x radius
};

/// Calls visit(cell) for every cell, coordinates divided by the scale of length.
template <class Visit>
void for_each_cell(const mesh::MeridianMesh& mesh, const assembly::Scales& scales, Visit visit) {
  const auto tables = make_tables(mesh.order);
  const auto p = static_cast<std::size_t>(mesh.order), side = p + 1;
  const std::array<std::size_t, 4> corner = {0, p, side * side - 1, side * p};
  Eigen::MatrixX2d at(static_cast<Eigen::Index>(mesh.nodes_per_element()), 2);
  Cell cell;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    cell.nodes = mesh.element(e);
    for (std::size_t k = 0; k < cell.nodes.size(); ++k) {
      const Vec2& x = mesh.nodes[static_cast<std::size_t>(cell.nodes[k])];
      at.row(static_cast<Eigen::Index>(k)) =
          Eigen::RowVector2d(x.x(), x.y() - scales.origin.z()) / scales.length;
    }
    std::size_t rule = 0, on_axis = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      if (at(static_cast<Eigen::Index>(corner[c]), 0) != 0) continue;
      ++on_axis;
      rule = c + 1;
    }
    const auto& table = tables[on_axis == 1 ? rule : 0];
    const Eigen::MatrixX2d by_u = table.by_u * at, by_v = table.by_v * at;
    const Eigen::VectorXd radius = table.values * at.col(0);
    const Eigen::ArrayXd determinant =
        by_u.col(0).array() * by_v.col(1).array() - by_u.col(1).array() * by_v.col(0).array();
    if (!(determinant.minCoeff() > 0) || !(radius.minCoeff() > 0)) {
      const Vec2& x = mesh.nodes[static_cast<std::size_t>(cell.nodes[0])];
      throw core::SolverError(
          fmt::format("the section's cell {} near radius {:.4g} m, height {:.4g} m is turned "
                      "inside out",
                      e, x.x(), x.y()),
          "the wall may be too thick for its curvature");
    }
    const auto inverse = determinant.inverse();
    cell.slopes[0] = (by_v.col(1).array() * inverse).matrix().asDiagonal() * table.by_u;
    cell.slopes[0] -= (by_u.col(1).array() * inverse).matrix().asDiagonal() * table.by_v;
    cell.slopes[1] = (by_u.col(0).array() * inverse).matrix().asDiagonal() * table.by_v;
    cell.slopes[1] -= (by_v.col(0).array() * inverse).matrix().asDiagonal() * table.by_u;
    cell.slopes[2] = radius.cwiseInverse().asDiagonal() * table.values;
    cell.values = &table.values;
    cell.volumes = (table.weights.array() * determinant * radius.array()).matrix();
    visit(cell);
  }
}

/// Strain k is the sum over components c (A, B, W) and slopes i of table[k][c][i] phi_i of c.
using StrainTable = std::array<std::array<std::array<double, 3>, 3>, strains>;

StrainTable strain_table(int n) {
  constexpr double s = 1 / std::numbers::sqrt2;
  const double m = n;
  // U = s (A + B), V = s (B - A):
  // rr = U_r; theta theta = (U + n V) / r; zz = W_z; rz = U_z + W_r;
  // r theta = V_r - (V + n U) / r; theta z = V_z - n W / r.
  return {{{{{s, 0, 0}, {s, 0, 0}, {0, 0, 0}}},
           {{{0, 0, s * (1 - m)}, {0, 0, s * (1 + m)}, {0, 0, 0}}},
           {{{0, 0, 0}, {0, 0, 0}, {0, 1, 0}}},
           {{{0, s, 0}, {0, s, 0}, {1, 0, 0}}},
           {{{-s, 0, s * (1 - m)}, {s, 0, -s * (1 + m)}, {0, 0, 0}}},
           {{{0, -s, 0}, {0, s, 0}, {0, 0, -m}}}}};
}

using Elasticity = Eigen::Matrix<double, strains, strains>;

Elasticity elasticity(const elements::Elastic& material, const assembly::Scales& scales) {
  const auto constants =
      elements::isotropic_constants(material.youngs_modulus / scales.modulus,
                                    material.poisson_ratio, material.density / scales.density);
  Elasticity d = Elasticity::Zero();
  d.topLeftCorner<3, 3>().setConstant(constants.lambda);
  for (Eigen::Index k = 0; k < strains; ++k) d(k, k) += (k < 3 ? 2 : 1) * constants.mu;
  return d;
}

/// Integral of cos^2 or sin^2 around.
double around(int n) {
  return n == 0 ? 2 * pi : pi;
}

/// Which of A, B, W are zero on the axis.
std::array<bool, 3> held_on_axis(int n) {
  if (n == 0) return {true, true, false};
  if (n == 1) return {false, true, true};
  return {true, true, true};
}

/// Nodes that share a cell, as node_graph() gives for tetrahedra.
assembly::NodeGraph graph_of(const mesh::MeridianMesh& mesh) {
  std::vector<std::vector<std::int32_t>> neighbours(mesh.nodes.size());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto cell = mesh.element(e);
    for (const auto a : cell) {
      auto& list = neighbours[static_cast<std::size_t>(a)];
      list.insert(list.end(), cell.begin(), cell.end());
    }
  }
  assembly::NodeGraph graph;
  graph.first.push_back(0);
  for (auto& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    graph.column.insert(graph.column.end(), list.begin(), list.end());
    graph.first.push_back(static_cast<std::int64_t>(graph.column.size()));
  }
  return graph;
}

void add_cell(const Cell& cell, HarmonicForms& forms) {
  std::array<Eigen::MatrixXd, 9> product;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::MatrixXd weighted = cell.volumes.asDiagonal() * cell.slopes[i];
    for (std::size_t j = 0; j < 3; ++j) {
      product[3 * i + j].noalias() = weighted.transpose() * cell.slopes[j];
    }
  }
  const Eigen::MatrixXd weighted = cell.volumes.asDiagonal() * *cell.values;
  const Eigen::MatrixXd mass = weighted.transpose() * *cell.values;
  const auto& graph = forms.graph;
  for (std::size_t a = 0; a < cell.nodes.size(); ++a) {
    const auto row = static_cast<std::size_t>(cell.nodes[a]);
    const auto first = graph.column.begin() + graph.first[row];
    const auto last = graph.column.begin() + graph.first[row + 1];
    for (std::size_t b = 0; b < cell.nodes.size(); ++b) {
      const auto at = static_cast<std::size_t>(std::lower_bound(first, last, cell.nodes[b]) -
                                               graph.column.begin());
      const auto i = static_cast<Eigen::Index>(a), j = static_cast<Eigen::Index>(b);
      for (std::size_t k = 0; k < 9; ++k) forms.products[at][k] += product[k](i, j);
      forms.mass[at] += mass(i, j);
    }
  }
}

}  // namespace

CylinderFields cylinder_fields(const Eigen::Ref<const Eigen::VectorXd>& unknowns) {
  const auto nodes = unknowns.size() / 3;
  const Eigen::Map<const Eigen::Matrix3Xd> abw(unknowns.data(), 3, nodes);
  return {(abw.row(0) + abw.row(1)).transpose() / std::numbers::sqrt2,
          (abw.row(1) - abw.row(0)).transpose() / std::numbers::sqrt2, abw.row(2).transpose()};
}

Eigen::VectorXd unknowns_of(const CylinderFields& fields) {
  Eigen::VectorXd out(3 * fields.radial.size());
  Eigen::Map<Eigen::Matrix3Xd> abw(out.data(), 3, fields.radial.size());
  abw.row(0) = (fields.radial - fields.around).transpose() / std::numbers::sqrt2;
  abw.row(1) = (fields.radial + fields.around).transpose() / std::numbers::sqrt2;
  abw.row(2) = fields.axial.transpose();
  return out;
}

HarmonicForms harmonic_forms(mesh::MeridianMesh mesh) {
  HarmonicForms forms;
  forms.material = {.youngs_modulus = 1, .poisson_ratio = 0.25, .density = 1};
  double radius = 0, low = mesh.nodes.front().y(), high = low;
  for (const auto& x : mesh.nodes) {
    radius = std::max(radius, x.x());
    low = std::min(low, x.y());
    high = std::max(high, x.y());
  }
  forms.scales = {std::max(2 * radius, high - low), 1, 1, Vec3(0, 0, (low + high) / 2)};
  forms.mesh = std::move(mesh);
  forms.graph = graph_of(forms.mesh);
  forms.products.assign(forms.graph.column.size(), {});
  forms.mass.assign(forms.graph.column.size(), 0.0);
  for_each_cell(forms.mesh, forms.scales, [&forms](const Cell& cell) { add_cell(cell, forms); });
  forms.plan = eigen::plan_factors(harmonic_system(forms, 0), MPI_COMM_SELF);
  return forms;
}

HarmonicForms in_material(HarmonicForms forms, const elements::Elastic& material) {
  forms.material = material;
  forms.scales.modulus = material.youngs_modulus;
  forms.scales.density = material.density;
  return forms;
}

assembly::System harmonic_system(const HarmonicForms& forms, int n) {
  assembly::System system;
  system.scales = forms.scales;
  system.graph = forms.graph;
  const auto nodes = static_cast<std::int32_t>(forms.mesh.nodes.size());
  system.partition.first = {0, nodes};
  system.partition.node.resize(forms.mesh.nodes.size());
  std::iota(system.partition.node.begin(), system.partition.node.end(), 0);
  system.partition.number = system.partition.node;
  system.mass = forms.mass;
  for (double& m : system.mass) m *= around(n);

  const auto strain = strain_table(n);
  const Elasticity d = elasticity(forms.material, forms.scales);
  /// Block (c, c') of a pair of nodes is the sum over its nine products of these.
  Eigen::Matrix<double, 9, 9> factor = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t k = 0; k < strains; ++k) {
    for (std::size_t l = 0; l < strains; ++l) {
      const double modulus =
          around(n) * d(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l));
      if (modulus == 0) continue;
      for (std::size_t cc = 0; cc < 9; ++cc) {
        for (std::size_t ij = 0; ij < 9; ++ij) {
          factor(static_cast<Eigen::Index>(cc), static_cast<Eigen::Index>(ij)) +=
              modulus * strain[k][cc / 3][ij / 3] * strain[l][cc % 3][ij % 3];
        }
      }
    }
  }
  const auto held = held_on_axis(n);
  const auto is_held = [&](std::int32_t node, std::size_t component) {
    return held[component] && forms.mesh.nodes[static_cast<std::size_t>(node)].x() == 0;
  };
  system.stiffness.resize(9 * forms.graph.column.size());
  double largest = 0;
  std::vector<std::size_t> springs;
  for (std::int32_t row = 0; row < nodes; ++row) {
    const auto begin = static_cast<std::size_t>(forms.graph.first[static_cast<std::size_t>(row)]);
    const auto end = static_cast<std::size_t>(forms.graph.first[static_cast<std::size_t>(row) + 1]);
    for (auto at = begin; at < end; ++at) {
      const auto column = forms.graph.column[at];
      const Eigen::Matrix<double, 9, 1> block =
          factor * Eigen::Map<const Eigen::Matrix<double, 9, 1>>(forms.products[at].data());
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t e = 0; e < 3; ++e) {
          const auto place = 9 * begin + c * 3 * (end - begin) + 3 * (at - begin) + e;
          const bool is_diagonal = row == column && c == e;
          if (is_held(row, c) || is_held(column, e)) {
            system.stiffness[place] = 0;
            if (is_diagonal) springs.push_back(place);
            continue;
          }
          system.stiffness[place] = block[static_cast<Eigen::Index>(3 * c + e)];
          if (is_diagonal) largest = std::max(largest, system.stiffness[place]);
        }
      }
    }
  }
  // Such a spring moves an eigenvalue by less than lambda m / k of itself, with m the node's mass,
  // and k / m is far above the mesh's own largest eigenvalue.
  for (const auto place : springs) system.stiffness[place] = 1e6 * largest;
  return system;
}

std::vector<double> rayleigh_quotients(const HarmonicForms& forms, int n,
                                       const Eigen::Ref<const Eigen::MatrixXd>& vectors) {
  const auto table = strain_table(n);
  const Elasticity d = elasticity(forms.material, forms.scales);
  const auto held = held_on_axis(n);
  const auto modes = vectors.cols();
  if (modes == 0) return {};
  Eigen::ArrayXd strain_energy = Eigen::ArrayXd::Zero(modes), kinetic = strain_energy;
  std::array<Eigen::MatrixXd, 3> u;
  for_each_cell(forms.mesh, forms.scales, [&](const Cell& cell) {
    for (std::size_t c = 0; c < 3; ++c) {
      u[c].resize(static_cast<Eigen::Index>(cell.nodes.size()), modes);
      for (std::size_t a = 0; a < cell.nodes.size(); ++a) {
        const auto node = static_cast<std::size_t>(cell.nodes[a]);
        const auto row = static_cast<Eigen::Index>(a);
        if (held[c] && forms.mesh.nodes[node].x() == 0) {
          u[c].row(row).setZero();
        } else {
          u[c].row(row) = vectors.row(static_cast<Eigen::Index>(3 * node + c));
        }
      }
    }
    std::array<Eigen::MatrixXd, strains> e;
    const auto points = cell.volumes.size();
    for (std::size_t k = 0; k < strains; ++k) {
      e[k] = Eigen::MatrixXd::Zero(points, modes);
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < 3; ++i) {
          if (table[k][c][i] != 0) e[k].noalias() += table[k][c][i] * (cell.slopes[i] * u[c]);
        }
      }
    }
    for (std::size_t k = 0; k < strains; ++k) {
      for (std::size_t l = 0; l < strains; ++l) {
        const double modulus = d(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l));
        if (modulus == 0) continue;
        strain_energy += modulus * (e[k].cwiseProduct(e[l]).transpose() * cell.volumes).array();
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const Eigen::MatrixXd value = *cell.values * u[c];
      kinetic += (value.cwiseAbs2().transpose() * cell.volumes).array();
    }
  });
  std::vector<double> out(static_cast<std::size_t>(modes));
  for (Eigen::Index k = 0; k < modes; ++k) {
    out[static_cast<std::size_t>(k)] = strain_energy[k] / kinetic[k];
  }
  return out;
}

Eigen::MatrixXd rigid_fields(const HarmonicForms& forms, int n) {
  const auto nodes = static_cast<Eigen::Index>(forms.mesh.nodes.size());
  if (n > 1) return Eigen::MatrixXd(3 * nodes, 0);
  Eigen::VectorXd r(nodes), z(nodes);
  for (Eigen::Index k = 0; k < nodes; ++k) {
    const Vec2& x = forms.mesh.nodes[static_cast<std::size_t>(k)];
    r[k] = x.x() / forms.scales.length;
    z[k] = (x.y() - forms.scales.origin.z()) / forms.scales.length;
  }
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(nodes), none = Eigen::VectorXd::Zero(nodes);
  Eigen::MatrixXd out(3 * nodes, 2);
  if (n == 0) {
    out.col(0) = unknowns_of({none, none, one});
    out.col(1) = unknowns_of({none, r, none});
  } else {
    out.col(0) = unknowns_of({one, -one, none});
    out.col(1) = unknowns_of({z, -z, -r});
  }
  return out;
}

double mass_of(const HarmonicForms& forms) {
  const double volume = std::accumulate(forms.mass.begin(), forms.mass.end(), 0.0);
  return 2 * pi * volume * forms.material.density * std::pow(forms.scales.length, 3);
}

}  // namespace carillon::solvers::axisymmetric
