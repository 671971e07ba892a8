#include "solvers/eigen/detail/finer_space.hpp"

#include <Eigen/QR>
#include <algorithm>

#include "solvers/eigen/detail/rigid.hpp"
#include "solvers/mesh/raise_order.hpp"

namespace carillon::solvers::eigen {
namespace {

/// The rigid motions of an element, orthonormal: 3 nodes x 6.
Eigen::MatrixXd rigid_motions(const elements::Coordinates& nodes) {
  elements::Coordinates arm = nodes.colwise() - nodes.rowwise().mean();
  arm /= arm.cwiseAbs().maxCoeff();
  Eigen::MatrixXd motions(3 * nodes.cols(), 6);
  for (Eigen::Index a = 0; a < nodes.cols(); ++a) {
    motions.middleRows<3>(3 * a) << rigid_motions_at(arm.col(a));
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(motions);
  return qr.householderQ() * Eigen::MatrixXd::Identity(motions.rows(), 6);
}

/// Elements whose first node a rank owns.
std::vector<std::size_t> elements_of(const mesh::TetMesh& mesh, const assembly::System& system) {
  std::vector<std::size_t> out;
  const auto begin = system.graph.begin, end = begin + system.graph.rows();
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto number = system.partition.number[static_cast<std::size_t>(mesh.element(e)[0])];
    if (number >= begin && number < end) out.push_back(e);
  }
  return out;
}

/// Where in Fields an owned node's three values begin.
Eigen::Index column_of(const assembly::System& system, Eigen::Index row) {
  const auto number = static_cast<std::size_t>(system.graph.begin + row);
  return 3 * static_cast<Eigen::Index>(system.partition.node[number]);
}

}  // namespace

void gather(const Fields& fields, std::span<const std::int32_t> element, Fields& local) {
  const auto block = 3 * fields.rows();
  local.resize(fields.rows(), 3 * static_cast<Eigen::Index>(element.size()));
  double* out = local.data();
  for (const auto node : element) {
    out = std::copy_n(fields.data() + node * block, block, out);
  }
}

void scatter_add(const Fields& local, std::span<const std::int32_t> element, Fields& fields) {
  const auto block = 3 * fields.rows();
  using Block = Eigen::Map<Eigen::VectorXd>;
  using ConstBlock = Eigen::Map<const Eigen::VectorXd>;
  Eigen::Index a = 0;
  for (const auto node : element) {
    Block(fields.data() + node * block, block) += ConstBlock(local.data() + a++ * block, block);
  }
}

Eigen::MatrixXd owned_rows(const assembly::System& system, const Fields& fields) {
  Eigen::MatrixXd owned(system.owned_unknowns(), fields.rows());
  for (Eigen::Index row = 0; row < system.graph.rows(); ++row) {
    owned.middleRows<3>(3 * row) = fields.middleCols<3>(column_of(system, row)).transpose();
  }
  return owned;
}

void add_owned(const assembly::System& system, const Eigen::Ref<const Eigen::MatrixXd>& owned,
               Fields& fields) {
  for (Eigen::Index row = 0; row < system.graph.rows(); ++row) {
    fields.middleCols<3>(column_of(system, row)) += owned.middleRows<3>(3 * row).transpose();
  }
}

Eigen::Map<Eigen::MatrixXd> by_node(Fields& local) {
  return {local.data(), 3 * local.rows(), local.cols() / 3};
}

Eigen::Map<const Eigen::MatrixXd> by_node(const Fields& local) {
  return {local.data(), 3 * local.rows(), local.cols() / 3};
}

void sum_over_ranks(Fields& fields, MPI_Comm comm) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  if (size == 1) return;
  // In pieces, so that counts stay far from 2^31.
  constexpr Eigen::Index piece = 1 << 27;
  for (Eigen::Index at = 0; at < fields.size(); at += piece) {
    const auto count = std::min(piece, fields.size() - at);
    MPI_Allreduce(MPI_IN_PLACE, fields.data() + at, static_cast<int>(count), MPI_DOUBLE, MPI_SUM,
                  comm);
  }
}

FinerSpace::FinerSpace(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                       const assembly::System& system, double shift, std::int64_t memory,
                       MPI_Comm comm)
    : comm_(comm),
      scales_(system.scales),
      mesh_(mesh::next_order(mesh)),
      gaps_(mesh.finer_gaps),
      materials_(assembly::elastic_constants(regions, system.scales)),
      mass_factor_(-shift),
      own_(elements_of(mesh, system)) {
  for (std::size_t n = 0; n < mesh_.nodes.size(); ++n) {
    const auto bits = system.mirror.held_at(mesh_.nodes[n]);
    for (int i = 0; i < 3; ++i) {
      if ((bits >> i & 1) != 0) held_.push_back(3 * static_cast<Eigen::Index>(n) + i);
    }
  }
  const std::int64_t nodes = elements::nodes_per_tetrahedron(mesh_.order);
  keeps_ = static_cast<std::int64_t>(own_.size()) * 10 * nodes * nodes * 8 <= memory;
  // What is put back may fold a neighbour; a chain of them is rare and short.
  constexpr int max_rounds = 5;
  std::vector<Vec3> own_curve;
  for (int round = 0; round <= max_rounds; ++round) {
    const auto folded = compute_own();
    sound_ = folded.empty();
    if (sound_) return;
    if (own_curve.empty()) own_curve = mesh::raise_order(mesh, mesh_.order).nodes;
    if (gaps_.empty()) gaps_.assign(mesh_.nodes.size(), Vec3::Zero());
    for (const auto e : folded) {
      for (const auto n : mesh_.element(e)) {
        const auto node = static_cast<std::size_t>(n);
        gaps_[node] += mesh_.nodes[node] - own_curve[node];
        mesh_.nodes[node] = own_curve[node];
      }
    }
  }
}

std::vector<std::size_t> FinerSpace::compute_own() {
  elements::ElementKernel kernel(mesh_.order);
  std::vector<unsigned char> folded(mesh_.element_count(), 0);
  matrices_.assign(keeps_ ? own_.size() : 0, Matrices());
  Matrices scratch;
  for (std::size_t k = 0; k < own_.size(); ++k) {
    auto& matrices = keeps_ ? matrices_[k] : scratch;
    if (!compute(kernel, own_[k], matrices)) folded[own_[k]] = 1;
  }
  MPI_Allreduce(MPI_IN_PLACE, folded.data(), static_cast<int>(folded.size()), MPI_UNSIGNED_CHAR,
                MPI_MAX, comm_);
  std::vector<std::size_t> out;
  for (std::size_t e = 0; e < folded.size(); ++e) {
    if (folded[e]) out.push_back(e);
  }
  return out;
}

bool FinerSpace::compute(elements::ElementKernel& kernel, std::size_t element, double closed,
                         Matrices& out) const {
  elements::Coordinates nodes;
  assembly::gather(mesh_, element, scales_, nodes);
  if (closed != 0) {
    Eigen::Index at = 0;
    for (const auto n : mesh_.element(element)) {
      nodes.col(at++) += closed / scales_.length * gaps_[static_cast<std::size_t>(n)];
    }
  }
  if (!(kernel.place(nodes) > 0)) return false;
  const auto& material = materials_[static_cast<std::size_t>(mesh_.regions[element])];
  kernel.stiffness(material, out.a);
  kernel.mass(material.density, out.mass);
  for (Eigen::Index j = 0; j < out.mass.cols(); ++j) {
    for (Eigen::Index i = 0; i < out.mass.rows(); ++i) {
      out.a.block<3, 3>(3 * i, 3 * j).diagonal().array() += mass_factor_ * out.mass(i, j);
    }
  }
  return true;
}

const FinerSpace::Matrices& FinerSpace::matrices(elements::ElementKernel& kernel, std::size_t own,
                                                 Matrices& scratch) const {
  if (keeps_) return matrices_[own];
  compute(kernel, own_[own], scratch);
  return scratch;
}

void FinerSpace::for_each_matrix(
    const std::function<void(std::size_t, const Eigen::MatrixXd&)>& use) const {
  elements::ElementKernel kernel(mesh_.order);
  std::vector<bool> touched(mesh_.nodes.size(), false);
  for (const auto e : own_) {
    for (const auto n : mesh_.element(e)) touched[static_cast<std::size_t>(n)] = true;
  }
  Matrices scratch;
  std::size_t next = 0;
  for (std::size_t e = 0; e < mesh_.element_count(); ++e) {
    if (next < own_.size() && own_[next] == e) {
      use(e, matrices(kernel, next++, scratch).a);
      continue;
    }
    const auto corners = mesh_.element(e).first(4);
    if (std::any_of(corners.begin(), corners.end(),
                    [&touched](std::int32_t n) { return touched[static_cast<std::size_t>(n)]; })) {
      compute(kernel, e, scratch);
      use(e, scratch.a);
    }
  }
}

void FinerSpace::forces(const Fields& x, Fields& stiff, Fields& inert) const {
  elements::ElementKernel kernel(mesh_.order);
  stiff.setZero(x.rows(), x.cols());
  inert.setZero(x.rows(), x.cols());
  Matrices scratch;
  elements::Coordinates nodes;
  Fields local, rigid, product(x.rows(), 3 * kernel.nodes());
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const auto element = mesh_.element(own_[k]);
    const auto& m = matrices(kernel, k, scratch);
    assembly::gather(mesh_, own_[k], scales_, nodes);
    const Eigen::MatrixXd motions = rigid_motions(nodes);
    gather(x, element, local);
    by_node(product).noalias() = by_node(local) * m.mass;
    scatter_add(product, element, inert);
    rigid.noalias() = (local * motions) * motions.transpose();
    local -= rigid;
    product.noalias() = local * m.a;
    scatter_add(product, element, stiff);
    by_node(product).noalias() = mass_factor_ * by_node(rigid) * m.mass;
    scatter_add(product, element, stiff);
  }
  sum_over_ranks(stiff, comm_);
  sum_over_ranks(inert, comm_);
  hold(stiff);
  hold(inert);
}

void FinerSpace::hold(Fields& fields) const {
  for (const auto column : held_) fields.col(column).setZero();
}

void FinerSpace::close_gaps(const Fields& x, Eigen::MatrixXd& stiff, Eigen::MatrixXd& inert) const {
  constexpr double step = 1e-3;
  elements::ElementKernel kernel(mesh_.order);
  stiff.setZero(x.rows(), x.rows());
  inert.setZero(x.rows(), x.rows());
  Matrices more, less;
  Fields local, product(x.rows(), 3 * kernel.nodes());
  for (const auto e : own_) {
    const auto element = mesh_.element(e);
    const bool whole = std::all_of(element.begin(), element.end(), [this](std::int32_t n) {
      return gaps_[static_cast<std::size_t>(n)].isZero(0);
    });
    if (whole || !compute(kernel, e, step, more) || !compute(kernel, e, -step, less)) continue;
    more.a = (more.a - less.a) / (2 * step);
    more.mass = (more.mass - less.mass) / (2 * step);
    gather(x, element, local);
    stiff.noalias() += local * more.a * local.transpose();
    by_node(product).noalias() = by_node(local) * more.mass;
    inert.noalias() += local * product.transpose();
  }
  sum_over_ranks(stiff, comm_);
  sum_over_ranks(inert, comm_);
}

template <typename Product>
void FinerSpace::sum_elements(const Fields& x, const Product& multiply, Fields& out) const {
  elements::ElementKernel kernel(mesh_.order);
  out.setZero(x.rows(), x.cols());
  Matrices scratch;
  Fields local, product(x.rows(), 3 * kernel.nodes());
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const auto element = mesh_.element(own_[k]);
    gather(x, element, local);
    multiply(local, matrices(kernel, k, scratch), product);
    scatter_add(product, element, out);
  }
  sum_over_ranks(out, comm_);
  hold(out);
}

void FinerSpace::apply(const Fields& x, Fields& out) const {
  const auto multiply = [](const Fields& local, const Matrices& m, Fields& product) {
    product.noalias() = local * m.a;
  };
  sum_elements(x, multiply, out);
}

Eigen::ArrayXd FinerSpace::weighted_energy(const Fields& x, std::span<const double> weights) const {
  elements::ElementKernel kernel(mesh_.order);
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(x.rows());
  Matrices scratch;
  Fields local;
  for (std::size_t k = 0; k < own_.size(); ++k) {
    if (weights[own_[k]] == 0) continue;
    gather(x, mesh_.element(own_[k]), local);
    sum += weights[own_[k]] *
           (local * matrices(kernel, k, scratch).a).cwiseProduct(local).rowwise().sum().array();
  }
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), static_cast<int>(sum.size()), MPI_DOUBLE, MPI_SUM, comm_);
  return sum;
}

void FinerSpace::apply_mass(const Fields& x, Fields& out) const {
  const auto multiply = [](const Fields& local, const Matrices& m, Fields& product) {
    by_node(product).noalias() = by_node(local) * m.mass;
  };
  sum_elements(x, multiply, out);
}

}  // namespace carillon::solvers::eigen
