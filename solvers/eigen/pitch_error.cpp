#include "solvers/eigen/pitch_error.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "core/numbers.hpp"
#include "solvers/eigen/detail/finer_correction.hpp"
#include "solvers/eigen/detail/finer_space.hpp"
#include "solvers/eigen/detail/rigid.hpp"
#include "solvers/mesh/inward_edges.hpp"

namespace carillon::solvers::eigen {
namespace {

/// The next order misses an error of its own, a part of that of the solved order 1, 2, ...: 3 to 20
/// % of it at most sizes, a third where a mode has hardly one element to a half wave or blunt
/// corners bound the field's smoothness, half of order 4's there; next to nothing where elements
/// are of order 1.
constexpr std::array<double, 4> saturation = {1.03, 1.15, 1.4, 1.5};
/// Finer elements only lower pitches: what rises is the geometry's, of which nearly all is seen.
constexpr double geometry_saturation = 1.05;
/// The warping of a bar's section takes even orders: where one element is all of the section, order
/// 3 gains half of what order 2 misses of twists, or less. Which modes twist is not asked: all are
/// said to be off by so much more.
constexpr double missed_by_sections = 0.4;
/// Elements wider than a wall is thick resolve nothing of what happens along its edges, at whatever
/// order: higher orders gain little of it, and miss so much more than they tell. That is a matter
/// of the first cents of a change; what exceeds them comes from elsewhere.
constexpr std::array<double, 4> missed_along_edges = {0, 0, 0.35, 1.1};
constexpr double edge_cents = 3;
/// What is missed at an inward edge and near it, by what the next order changes there. With a field
/// r^alpha in elements of one size the error falls as order^(-4 alpha) at the edge (Babuska and
/// Suri 1987), and in elements that it only passes by as rho^(-2 order) if that is faster. Orders
/// as low as these are up to 13 % short of that rate.
double missed_at_edge(const mesh::NearestEdge& edge, int order) {
  constexpr double short_of_rate = 1.15;
  const double at = std::pow(order / (order + 1.0), 4 * edge.exponent);
  return short_of_rate / (1 - std::min(at, 1 / (edge.rho * edge.rho)));
}

/// Faceted or flattened surfaces raise or lower a pitch, elements too stiff raise it. Where the two
/// cancel, this part of either is left of what their measurement misses.
constexpr double uncancelled = 0.04;
/// [cents] Below this the solvers' tolerances count.
constexpr double smallest_error = 0.01;
/// Modes treated at once: as many as memory allows, and enough for neighbours to be told apart.
constexpr std::int64_t min_block = 8, largest_block = 128;
/// Arrays as large as the fields that live at the same time.
constexpr std::int64_t field_arrays = 9;

/// Of a ratio of eigenvalues.
double pitch_change(double ratio) {
  return 0.5 * core::cents(ratio);
}

/// What a mesh's solved order misses, by what the next order changes.
class Saturation {
 public:
  Saturation(int order, bool is_flat)
      : power_(saturation.at(static_cast<std::size_t>(order - 1))),
        along_edges_(is_flat ? missed_along_edges.at(static_cast<std::size_t>(order - 1)) : 0) {}

  /// @param change   [cent], and so is the result
  /// @param further  what inward edges add to the factor
  double missed(double change, double further) const {
    if (change > 0) return geometry_saturation * change;
    return (power_ + further) * change + along_edges_ * std::max(change, -edge_cents);
  }

 private:
  double power_, along_edges_;
};

/// Takes rigid motions out of fields: shapes that are orthogonal to them on the solved order's
/// curved elements are not quite so on the next order's.
class RigidPart {
 public:
  RigidPart(const FinerSpace& space, const assembly::System& system)
      : component_(mesh::node_components(space.mesh())) {
    const std::vector<int> kinds = system.mirror.rigid_motions();
    const auto each = static_cast<Eigen::Index>(kinds.size());
    if (each == 0) return;
    const Vec3 middle = system.mirror.planes.empty()
                            ? system.scales.origin
                            : Vec3((system.mirror.box.low + system.mirror.box.high) / 2);
    const auto& nodes = space.mesh().nodes;
    motions_.resize(each, 3 * static_cast<Eigen::Index>(nodes.size()));
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const Vec3 arm = (nodes[n] - middle) / system.scales.length;
      motions_.middleCols<3>(column(n)) = rigid_motions_at(arm)(Eigen::all, kinds).transpose();
    }
    space.hold(motions_);
    space.apply_mass(motions_, inert_);
    const auto count = *std::max_element(component_.begin(), component_.end()) + 1;
    gram_.assign(static_cast<std::size_t>(count), Eigen::MatrixXd::Zero(each, each));
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      gram_[component(n)] +=
          motions_.middleCols<3>(column(n)) * inert_.middleCols<3>(column(n)).transpose();
    }
  }

  void remove_from(Fields& x) const {
    if (gram_.empty()) return;
    std::vector<Eigen::MatrixXd> fraction(gram_.size(),
                                          Eigen::MatrixXd::Zero(motions_.rows(), x.rows()));
    for (std::size_t n = 0; n < component_.size(); ++n) {
      fraction[component(n)] +=
          inert_.middleCols<3>(column(n)) * x.middleCols<3>(column(n)).transpose();
    }
    for (std::size_t c = 0; c < gram_.size(); ++c)
      fraction[c] = gram_[c].ldlt().solve(fraction[c]).eval();
    for (std::size_t n = 0; n < component_.size(); ++n) {
      x.middleCols<3>(column(n)) -=
          fraction[component(n)].transpose() * motions_.middleCols<3>(column(n));
    }
  }

 private:
  static Eigen::Index column(std::size_t node) { return 3 * static_cast<Eigen::Index>(node); }
  std::size_t component(std::size_t node) const {
    return static_cast<std::size_t>(component_[node]);
  }

  std::vector<std::int32_t> component_;
  Fields motions_, inert_;
  std::vector<Eigen::MatrixXd> gram_;  ///< of each component's motions
};

/// The quadratic forms of A and M on the fields x and their corrections d, and what they gain when
/// the gaps of the next order's nodes close.
struct Projected {
  Eigen::MatrixXd a, m;
  Eigen::Index fields = 0;
  Eigen::MatrixXd a_gain, m_gain;  ///< empty where there is no gap
};

Projected project(const Fields& x, const Fields& ax, const Fields& mx, const Fields& d,
                  const Fields& ad, const Fields& md) {
  const auto n = x.rows();
  Projected out{Eigen::MatrixXd(2 * n, 2 * n), Eigen::MatrixXd(2 * n, 2 * n), n, {}, {}};
  const auto fill = [n, &x, &d](const Fields& px, const Fields& pd, Eigen::MatrixXd& form) {
    form.topLeftCorner(n, n) = x * px.transpose();
    form.bottomLeftCorner(n, n) = d * px.transpose();
    form.topRightCorner(n, n) = form.bottomLeftCorner(n, n).transpose();
    form.bottomRightCorner(n, n) = d * pd.transpose();
    form = ((form + form.transpose()) / 2).eval();
  };
  fill(ax, ad, out.a);
  fill(mx, md, out.m);
  return out;
}

/// What the modes should be, by Rayleigh and Ritz's procedure.
/// @param values  eigenvalues of the solved order, dimensionless
/// @param shift   sigma
/// @param further  what inward edges add to each field's factor
/// @param margin   of all modes
TrueModes true_modes(Projected form, const Eigen::ArrayXd& values, double shift,
                     const Saturation& saturated, const Eigen::ArrayXd& further, double margin) {
  const auto fields = form.fields;
  const Eigen::VectorXd scale =
      form.m.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt().cwiseInverse();
  form.a = scale.asDiagonal() * form.a * scale.asDiagonal();
  form.m = scale.asDiagonal() * form.m * scale.asDiagonal();
  const bool has_gaps = form.a_gain.size() > 0;
  if (has_gaps) {
    form.a_gain = scale.asDiagonal() * form.a_gain * scale.asDiagonal();
    form.m_gain = scale.asDiagonal() * form.m_gain * scale.asDiagonal();
  }
  // Corrections that depend on the others but for rounding are left out.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> basis(form.m);
  const auto kept = (basis.eigenvalues().array() > 1e-10).count();
  const Eigen::MatrixXd whitened =
      basis.eigenvectors().rightCols(kept) *
      basis.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(whitened.transpose() * form.a *
                                                            whitened);
  // The given modes' successors lie nearest to their span; the others are remnants of corrections.
  const Eigen::MatrixXd products = form.m.topRows(fields) * whitened * ritz.eigenvectors();
  const Eigen::MatrixXd fractions = form.m.topLeftCorner(fields, fields).ldlt().solve(products);
  const Eigen::ArrayXd overlap = products.cwiseProduct(fractions).colwise().sum().transpose();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(kept));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&overlap](Eigen::Index i, Eigen::Index j) { return overlap[i] > overlap[j]; });
  TrueModes out{{}, fractions(Eigen::all, std::vector(order.begin(), order.begin() + fields))};
  for (Eigen::Index k = 0; k < fields; ++k) {
    const auto j = order[static_cast<std::size_t>(k)];
    // Where this shape lay at the solved order, whatever mixture of modes it was there.
    const Eigen::ArrayXd weight = fractions.col(j).array().square().square();
    const double before = (weight * values).sum() / weight.sum();
    const double after = std::max(ritz.eigenvalues()[j] + shift, 0.0);
    // The same field, not yet corrected, on the next order's geometry.
    const Eigen::VectorXd corrected = whitened * ritz.eigenvectors().col(j);
    const auto field = corrected.head(fields);
    const double moved = field.dot(form.a.topLeftCorner(fields, fields) * field) /
                             field.dot(form.m.topLeftCorner(fields, fields) * field) +
                         shift;
    // Not all that may be missed is missed: half of it tells best in which order modes come.
    const double measured = pitch_change(after / before);
    const double at_edges = (weight * further).sum() / weight.sum();
    double change = saturated.missed(measured, at_edges), likely = (measured + change) / 2;
    if (has_gaps) {
      const double gain = corrected.dot(form.a_gain * corrected) -
                          ritz.eigenvalues()[j] * corrected.dot(form.m_gain * corrected);
      const double closed = pitch_change(std::exp(std::clamp(gain / after, -1.0, 1.0)));
      change += closed;
      likely += closed;
    }
    out.modes.push_back({before, before * std::exp2(change / 600),
                         uncancelled * std::abs(pitch_change(moved / before)),
                         before * std::exp2(likely / 600), margin});
  }
  return out;
}

class Estimator {
 public:
  Estimator(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
            const assembly::System& system, const ShiftedSystem& shifted, const FinerSpace& space,
            const ErrorMargins& margins, std::int64_t memory, MPI_Comm comm)
      : shift_(shifted.shift),
        saturation_(mesh.order, margins.is_flat),
        further_(margins.at_edges),
        margin_(mesh.order == 2 ? 1 + missed_by_sections * margins.section_fraction : 1),
        space_(space),
        comm_(comm),
        correction_(mesh, regions, system, shifted, space, memory, comm),
        rigid_(space, system) {}

  /// @param owned   modes, owned unknowns x modes
  /// @param values  their eigenvalues, dimensionless, ascending
  TrueModes true_modes_of(const Eigen::Ref<const Eigen::MatrixXd>& owned,
                          const Eigen::ArrayXd& values) const {
    Fields x = correction_.prolong(owned), ax, mx;
    rigid_.remove_from(x);
    space_.forces(x, ax, mx);
    const Eigen::ArrayXd norm = dots(x, mx, comm_).sqrt();
    for (auto* fields : {&x, &ax, &mx}) {
      for (Eigen::Index j = 0; j < x.cols(); ++j) fields->col(j).array() /= norm;
    }
    // A (x + d) = theta M x, theta the Rayleigh quotient.
    const Eigen::ArrayXd theta = dots(x, ax, comm_);
    Fields right(x.rows(), x.cols());
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      right.col(j).array() = theta * mx.col(j).array() - ax.col(j).array();
    }
    Fields ad = right, md;
    CorrectionGoal goal;
    goal.negligible = (smallest_error * std::numbers::ln2 / 600) * values;
    const Fields d = correction_.solve(right, goal);
    ad -= right;
    right.resize(0, 0);
    const Eigen::ArrayXd further = space_.weighted_energy(d, further_) /
                                   dots(d, ad, comm_).max(std::numeric_limits<double>::min());
    space_.apply_mass(d, md);
    auto form = project(x, ax, mx, d, ad, md);
    if (space_.has_gaps()) {
      Fields both(2 * x.rows(), x.cols());
      both << x, d;
      space_.close_gaps(both, form.a_gain, form.m_gain);
    }
    return true_modes(std::move(form), values, shift_, saturation_, further, margin_);
  }

 private:
  double shift_;
  Saturation saturation_;
  const std::vector<double>& further_;  ///< for each element
  double margin_;
  const FinerSpace& space_;
  MPI_Comm comm_;
  FinerCorrection correction_;
  RigidPart rigid_;
};

/// How many modes to treat at once: blocks of equal size within the bounds.
Eigen::Index block_size(Eigen::Index modes, std::size_t nodes, std::int64_t memory) {
  const auto by_mode = field_arrays * 24 * static_cast<std::int64_t>(nodes);
  const auto maximum = std::clamp(memory / by_mode, min_block, largest_block);
  const auto blocks = (modes + maximum - 1) / maximum;
  return (modes + blocks - 1) / blocks;
}

}  // namespace

std::int64_t min_estimate_bytes(const mesh::TetMesh& mesh, MPI_Comm comm) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  const int next = mesh.order + 1;
  const auto blocks = LocalSolves::bytes(mesh.element_count(), next);
  const double nodes = static_cast<double>(mesh.nodes.size()) * std::pow(next / (next - 1.0), 3);
  return blocks + ranks * min_block * field_arrays * static_cast<std::int64_t>(24 * nodes);
}

std::vector<double> pitch_errors(std::span<const double> found, std::vector<TrueMode> truth) {
  constexpr double unknown = std::numeric_limits<double>::infinity();
  for (auto& mode : truth) {
    if (!(mode.eigenvalue > 0)) mode.eigenvalue = unknown;
    if (!(mode.likely > 0)) mode.likely = mode.eigenvalue;
    if (!(mode.uncertainty >= 0)) mode.uncertainty = unknown;
  }
  std::sort(truth.begin(), truth.end(),
            [](const TrueMode& a, const TrueMode& b) { return a.likely < b.likely; });
  std::vector<double> out;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const double error = truth[k].margin * std::abs(pitch_change(found[k] / truth[k].eigenvalue));
    out.push_back(std::max({smallest_error, truth[k].uncertainty, error}) + truth[k].added);
  }
  return out;
}

ErrorMargins error_margins(const mesh::TetMesh& mesh, const mesh::TetMesh& finer) {
  ErrorMargins margins;
  margins.is_flat = is_flat(mesh);
  const std::vector<bool> is_section = mesh::between_sharp_edges(mesh);
  margins.section_fraction =
      static_cast<double>(std::count(is_section.begin(), is_section.end(), true)) /
      static_cast<double>(std::max<std::size_t>(1, is_section.size()));
  const double usual = saturation.at(static_cast<std::size_t>(mesh.order - 1));
  for (const mesh::NearestEdge& edge : mesh::nearest_edges(finer))
    margins.at_edges.push_back(std::max(0.0, missed_at_edge(edge, mesh.order) - usual));
  return margins;
}

TrueModes estimate_true_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                              const assembly::System& system, const SearchResult& found,
                              std::span<const std::size_t> chosen,
                              std::span<const double> eigenvalues, std::int64_t memory,
                              MPI_Comm comm, const ErrorMargins* margins) {
  const auto count = static_cast<Eigen::Index>(chosen.size());
  TrueModes out{{}, Eigen::MatrixXd::Identity(count, count)};
  for (const double value : eigenvalues) {
    out.modes.push_back({value, std::numeric_limits<double>::infinity(), 0, 0});
  }
  if (chosen.empty()) return out;
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  // Half for a factor of the next order, a quarter for element matrices, a quarter for fields.
  const auto for_factor = memory / 2, for_each = memory / ranks / 4;
  const FinerSpace space(mesh, regions, system, found.shifted.shift, for_each, comm);
  if (!space.is_sound()) return out;
  const ErrorMargins own = margins ? ErrorMargins() : error_margins(mesh, space.mesh());
  const Estimator estimator(mesh, regions, system, found.shifted, space, margins ? *margins : own,
                            for_factor, comm);
  const double unit = system.scales.eigenvalue();
  const auto block = block_size(count, space.mesh().nodes.size(), for_each);
  for (Eigen::Index first = 0; first < count; first += block) {
    const auto size = std::min(block, count - first);
    Eigen::MatrixXd owned(found.pairs.vectors.rows(), size);
    Eigen::ArrayXd values(size);
    for (Eigen::Index k = 0; k < size; ++k) {
      const auto mode = static_cast<std::size_t>(first + k);
      owned.col(k) = found.pairs.vectors.col(static_cast<Eigen::Index>(chosen[mode]));
      values[k] = eigenvalues[mode] / unit;
    }
    const auto truth = estimator.true_modes_of(owned, values);
    out.fractions.block(first, first, size, size) = truth.fractions;
    for (Eigen::Index k = 0; k < size; ++k) {
      const auto& mode = truth.modes[static_cast<std::size_t>(k)];
      out.modes[static_cast<std::size_t>(first + k)] = {unit * mode.found, unit * mode.eigenvalue,
                                                        mode.uncertainty, unit * mode.likely,
                                                        mode.margin};
    }
  }
  MPI_Bcast(out.modes.data(), static_cast<int>(sizeof(TrueMode) * out.modes.size()), MPI_BYTE, 0,
            comm);
  MPI_Bcast(out.fractions.data(), static_cast<int>(out.fractions.size()), MPI_DOUBLE, 0, comm);
  return out;
}

}  // namespace carillon::solvers::eigen
