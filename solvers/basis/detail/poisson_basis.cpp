#include "solvers/basis/detail/poisson_basis.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mpi/comm.hpp"
#include "solvers/assembly/fields.hpp"
#include "solvers/assembly/products.hpp"
#include "solvers/basis/detail/poisson_bounds.hpp"
#include "solvers/dense/eigenpairs.hpp"

namespace carillon::solvers::basis {
namespace {

/// Part of a mode that may be left out of the basis: its square, times the ratio of the largest
/// Ritz value to the mode's, is the error.
constexpr double dropped = 1e-6;
/// Relative distance of a Ritz value from its bound that a count tolerates: 0.1 cents.
constexpr double tightness = 1.2e-4;

Eigen::MatrixXd product_over_ranks(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                   const Eigen::Ref<const Eigen::MatrixXd>& b, MPI_Comm comm) {
  Eigen::MatrixXd out = a.transpose() * b;
  MPI_Allreduce(MPI_IN_PLACE, out.data(), static_cast<int>(out.size()), MPI_DOUBLE, MPI_SUM, comm);
  return out;
}

/// Widens an M-orthonormal basis by what new vectors add to it.
/// @return coordinates of the vectors in the wider basis
Eigen::MatrixXd widen(PoissonBasis& basis, const assembly::System& system, Eigen::MatrixXd vectors,
                      MPI_Comm comm) {
  const assembly::Products products(system, comm);
  Eigen::MatrixXd mass_vectors(vectors.rows(), vectors.cols());
  products.mass(vectors, mass_vectors);
  const auto before = basis.size();
  Eigen::MatrixXd inside = Eigen::MatrixXd::Zero(before, vectors.cols());
  // Twice is enough (Kahan and Parlett).
  for (int pass = 0; pass < 2 && before > 0; ++pass) {
    const auto part = product_over_ranks(basis.vectors, mass_vectors, comm);
    vectors.noalias() -= basis.vectors * part;
    products.mass(vectors, mass_vectors);
    inside += part;
  }
  auto gram = product_over_ranks(vectors, mass_vectors, comm);
  gram = (gram + gram.transpose()).eval() / 2;
  const auto sizes = dense::symmetric_eigenpairs(gram);
  const auto kept = (sizes.array() > dropped * dropped).count();
  const Eigen::MatrixXd turned =
      gram.rightCols(kept) * sizes.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  basis.vectors.conservativeResize(vectors.rows(), before + kept);
  basis.vectors.rightCols(kept).noalias() = vectors * turned;
  Eigen::MatrixXd coordinates(before + kept, vectors.cols());
  coordinates << inside,
      sizes.tail(kept).cwiseSqrt().asDiagonal() * gram.rightCols(kept).transpose();
  return coordinates;
}

Eigen::MatrixXd columns_of(const Eigen::MatrixXd& matrix, std::span<const std::size_t> chosen) {
  Eigen::MatrixXd out(matrix.rows(), static_cast<Eigen::Index>(chosen.size()));
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    out.col(static_cast<Eigen::Index>(k)) = matrix.col(static_cast<Eigen::Index>(chosen[k]));
  }
  return out;
}

std::vector<elements::Elastic> with_ratio(std::vector<elements::Elastic> regions, double ratio) {
  for (auto& region : regions) region.poisson_ratio = ratio;
  return regions;
}

/// Constants of every region with lambda and mu for unit modulus replaced by these.
std::vector<elements::ElasticConstants> constants(const PoissonBasis& basis, double lambda,
                                                  double mu) {
  std::vector<elements::ElasticConstants> out;
  for (const auto& region : basis.regions) {
    const double modulus = region.youngs_modulus / basis.system->scales.modulus;
    out.push_back({lambda * modulus, mu * modulus, 0});
  }
  return out;
}

/// Fills lambda_part and mu_part.
void project(const mesh::TetMesh& mesh, PoissonBasis& basis, MPI_Comm comm) {
  constexpr Eigen::Index at_a_time = 256;
  const auto size = basis.size();
  basis.lambda_part.resize(size, size);
  basis.mu_part.resize(size, size);
  const std::vector<elements::ElasticConstants> parts[] = {constants(basis, 1, 0),
                                                           constants(basis, 0, 1)};
  for (Eigen::Index first = 0; first < size; first += at_a_time) {
    const auto count = std::min(at_a_time, size - first);
    const auto products = assembly::apply_stiffness(mesh, *basis.system, parts,
                                                    basis.vectors.middleCols(first, count), comm);
    basis.lambda_part.middleCols(first, count) =
        product_over_ranks(basis.vectors, products[0], comm);
    basis.mu_part.middleCols(first, count) = product_over_ranks(basis.vectors, products[1], comm);
  }
  for (auto* part : {&basis.lambda_part, &basis.mu_part}) {
    *part = ((*part + part->transpose()) / 2).eval();
  }
}

/// K(ratio) is at least this times M on the M-orthogonal complement of the Ritz vectors.
double complement_ceiling(const PoissonBasis& basis, double ratio,
                          const Eigen::MatrixXd& coordinates) {
  std::vector<double> ratios;
  for (const auto& snapshot : basis.snapshots) ratios.push_back(snapshot.poisson_ratio);
  const auto weights = stiffness_weights(ratios, ratio);
  std::vector<KnownSpectrum> known;
  for (std::size_t s = 0; s < weights.size(); ++s) {
    if (weights[s] == 0) continue;
    const auto& snapshot = basis.snapshots[s];
    const auto below = (snapshot.eigenvalues.array() < snapshot.complete_below).count();
    known.push_back({weights[s], snapshot.eigenvalues.head(below), snapshot.complete_below,
                     snapshot.coordinates.leftCols(below)});
  }
  return complement_bound(known, coordinates);
}

/// Estimates those of a snapshot's modes that requests can reach.
eigen::TrueModes estimate(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                          const assembly::System& system, const eigen::SearchResult& found,
                          const eigen::SolveOptions& options, const eigen::ErrorMargins* margins,
                          MPI_Comm comm) {
  // A tenth more than the bands, in frequency and in number.
  constexpr double part = 1.1 / beyond;
  const auto count = found.flexible.size();
  const double top = part * part * system.scales.from_frequency(options.band.max_frequency);
  std::size_t maximum =
      std::min(count, static_cast<std::size_t>(part * static_cast<double>(count)) + 1);
  while (maximum < count && found.pairs.values[found.flexible[maximum]] < top) ++maximum;
  std::vector<double> eigenvalues;
  for (std::size_t k = 0; k < maximum; ++k) {
    eigenvalues.push_back(found.pairs.values[found.flexible[k]] * system.scales.eigenvalue());
  }
  return eigen::estimate_true_modes(
      mesh, regions, system, found, std::span(found.flexible).first(maximum), eigenvalues,
      std::min(options.memory_limit / 4, found.spare_memory), comm, margins);
}

/// True modes of Ritz pairs: each should lie as much lower as those of the neighbouring snapshots
/// do that it overlaps.
std::vector<eigen::TrueMode> carry_errors(const PoissonBasis& basis, double ratio,
                                          const std::vector<double>& values,
                                          const Eigen::MatrixXd& coordinates) {
  std::vector<double> ratios;
  for (const auto& snapshot : basis.snapshots) ratios.push_back(snapshot.poisson_ratio);
  const auto weights = stiffness_weights(ratios, ratio);
  Eigen::ArrayXd rise = Eigen::ArrayXd::Zero(coordinates.cols()), uncertainty = rise;
  double sum = 0;
  for (std::size_t s = 0; s < weights.size(); ++s) {
    const auto& [modes, fractions] = basis.snapshots[s].truth;
    if (weights[s] == 0 || modes.empty()) continue;
    // Other modes than the ones it comes from are noise; squared again, they do not count.
    const Eigen::MatrixXd own =
        basis.snapshots[s].coordinates.leftCols(fractions.rows()) * fractions;
    const Eigen::ArrayXXd part = (own.transpose() * coordinates).array().square().square();
    const Eigen::ArrayXd whole = part.colwise().sum().max(1e-300).transpose();
    Eigen::ArrayXd own_rise(fractions.cols()), own_uncertainty(fractions.cols());
    for (std::size_t j = 0; j < modes.size(); ++j) {
      const auto row = static_cast<Eigen::Index>(j);
      own_rise[row] = std::log(modes[j].eigenvalue / modes[j].found);
      own_uncertainty[row] = modes[j].uncertainty;
    }
    sum += weights[s];
    rise += weights[s] * (part.colwise() * own_rise).colwise().sum().transpose() / whole;
    uncertainty +=
        weights[s] * (part.colwise() * own_uncertainty).colwise().sum().transpose() / whole;
  }
  std::vector<eigen::TrueMode> truth;
  for (Eigen::Index k = 0; k < rise.size(); ++k) {
    const double found = values[static_cast<std::size_t>(k)];
    truth.push_back({found, found * std::exp(rise[k] / sum), uncertainty[k] / sum});
  }
  return truth;
}

}  // namespace

std::optional<PoissonBasis> make_poisson_basis(const mesh::TetMesh& mesh,
                                               std::span<const elements::Elastic> regions,
                                               std::span<const double> ratios,
                                               const eigen::SolveOptions& options,
                                               const assembly::MirrorClass& mirror,
                                               const eigen::ErrorMargins* margins, MPI_Comm comm,
                                               core::Trace& trace) {
  PoissonBasis basis;
  basis.regions.assign(regions.begin(), regions.end());
  basis.reference = ratios[ratios.size() / 2];
  // The reference comes last: its factor stays, and two need not fit at once.
  std::vector<double> order(ratios.begin(), ratios.end());
  std::stable_partition(order.begin(), order.end(),
                        [&basis](double ratio) { return ratio != basis.reference; });
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  for (const double ratio : order) {
    const auto materials = with_ratio(basis.regions, ratio);
    auto system = std::make_shared<assembly::System>();
    assembly::Partition part;
    {
      const core::ScopedTimer timer(trace.stages["partition"]);
      mpi::agreed_in_group(comm, [&] { part = assembly::partition(mesh, ranks); });
    }
    {
      const core::ScopedTimer timer(trace.stages["assemble"]);
      *system = assembly::assemble(mesh, materials, std::move(part), comm, mirror);
    }
    auto found = eigen::search_modes(mesh, materials, options, *system, comm, trace);
    const auto modes = static_cast<double>(found.flexible.size());
    const double vectors = modes * static_cast<double>(ratios.size() + 6);
    if (8 * vectors * static_cast<double>(system->unknowns()) >
        static_cast<double>(options.memory_limit) / 2) {
      return std::nullopt;
    }
    const core::ScopedTimer timer(trace.stages["basis"]);
    Snapshot snapshot;
    snapshot.poisson_ratio = ratio;
    snapshot.complete_below = found.verified_below;
    snapshot.eigenvalues.resize(static_cast<Eigen::Index>(found.flexible.size()));
    for (std::size_t k = 0; k < found.flexible.size(); ++k) {
      snapshot.eigenvalues[static_cast<Eigen::Index>(k)] = found.pairs.values[found.flexible[k]];
    }
    if (!found.flexible.empty()) {
      snapshot.coordinates =
          widen(basis, *system, columns_of(found.pairs.vectors, found.flexible), comm);
    }
    if (options.estimate_errors && !found.flexible.empty()) {
      const core::ScopedTimer estimating(trace.stages["estimate"]);
      snapshot.truth = estimate(mesh, materials, *system, found, options, margins, comm);
    }
    basis.snapshots.push_back(std::move(snapshot));
    basis.components = found.components;
    basis.counted = basis.counted && found.counted;
    basis.eigen_solver = found.eigen_solver;
    basis.linear_solver = found.linear_solver;
    if (ratio == basis.reference) {
      basis.shifted = std::move(found.shifted);
      basis.system = std::move(system);
    }
  }
  const core::ScopedTimer timer(trace.stages["basis"]);
  for (auto& snapshot : basis.snapshots) {
    // Later directions are orthogonal to it.
    const auto before = snapshot.coordinates.rows();
    snapshot.coordinates.conservativeResize(basis.size(), Eigen::NoChange);
    snapshot.coordinates.bottomRows(basis.size() - before).setZero();
  }
  std::sort(basis.snapshots.begin(), basis.snapshots.end(),
            [](const Snapshot& a, const Snapshot& b) { return a.poisson_ratio < b.poisson_ratio; });
  if (basis.size() > 0 && !basis.shifted.inverse) return std::nullopt;
  project(mesh, basis, comm);
  return basis;
}

namespace {

/// Dense Ritz pairs of one Poisson's ratio.
struct DensePairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd coordinates;
};

/// The lowest Ritz pairs as fields, with their residuals and what these prove.
RitzModes bounded_pairs(const mesh::TetMesh& mesh, const PoissonBasis& basis, double ratio,
                        const DensePairs& dense, Eigen::Index count, MPI_Comm comm) {
  RitzModes out;
  out.coordinates = dense.coordinates.leftCols(count);
  const Eigen::VectorXd values = dense.values.head(count);
  auto& pairs = out.found.pairs;
  pairs.vectors.noalias() = basis.vectors * out.coordinates;
  pairs.mass_vectors.resize(pairs.vectors.rows(), count);
  assembly::Products(*basis.system, comm).mass(pairs.vectors, pairs.mass_vectors);
  const auto unit = elements::isotropic_constants(1, ratio, 0);
  const std::vector<elements::ElasticConstants> material[] = {
      constants(basis, unit.lambda, unit.mu)};
  auto residuals =
      std::move(assembly::apply_stiffness(mesh, *basis.system, material, pairs.vectors, comm)[0]);
  residuals.noalias() -= pairs.mass_vectors * values.asDiagonal();
  Eigen::MatrixXd solved(residuals.rows(), residuals.cols());
  if (count > 0) basis.shifted.inverse(residuals, solved);
  auto gram = product_over_ranks(residuals, solved, comm);
  gram = (gram + gram.transpose()).eval() / 2;

  const double ceiling = complement_ceiling(basis, ratio, out.coordinates);
  Eigen::VectorXd lower = Eigen::VectorXd::Zero(count);
  if (ceiling > 0) {
    // On the complement A = K(reference) - sigma M, which the residuals were measured with, is at
    // most so many times K(ratio).
    const double from_reference =
        1 / stiffness_ratio(basis.reference, ratio) - basis.shifted.shift / ceiling;
    const auto bounds = bound_ritz_values(values, from_reference * gram, ceiling, tightness);
    lower = bounds.lower;
    out.found.verified_below = bounds.counted_below;
  }
  for (Eigen::Index k = 0; k < count; ++k) {
    out.found.flexible.push_back(static_cast<std::size_t>(k));
    pairs.values.push_back(values[k]);
    pairs.energy_residuals.push_back(std::sqrt(std::max(0.0, gram(k, k)) / values[k]));
    out.lower.push_back(lower[k]);
  }
  pairs.residuals = pairs.energy_residuals;
  auto identity = product_over_ranks(pairs.vectors, pairs.mass_vectors, comm);
  identity.diagonal().array() -= 1;
  pairs.orthonormality = count == 0 ? 0 : identity.cwiseAbs().maxCoeff();
  return out;
}

/// Leaves out all but the lowest pairs.
void keep(RitzModes& modes, Eigen::Index count) {
  const auto size = static_cast<std::size_t>(count);
  auto& pairs = modes.found.pairs;
  for (auto* list : {&pairs.values, &pairs.residuals, &pairs.energy_residuals, &modes.lower}) {
    list->resize(size);
  }
  modes.found.flexible.resize(size);
  pairs.vectors.conservativeResize(Eigen::NoChange, count);
  pairs.mass_vectors.conservativeResize(Eigen::NoChange, count);
  modes.coordinates.conservativeResize(Eigen::NoChange, count);
}

}  // namespace

RitzModes ritz_modes(const mesh::TetMesh& mesh, const PoissonBasis& basis, double poisson_ratio,
                     const RitzRequest& request, MPI_Comm comm) {
  const auto unit = elements::isotropic_constants(1, poisson_ratio, 0);
  DensePairs dense;
  dense.coordinates = unit.lambda * basis.lambda_part + unit.mu * basis.mu_part;
  dense.values = dense::symmetric_eigenpairs(dense.coordinates);
  const auto below = [&dense](double value) -> Eigen::Index {
    return (dense.values.array() < value).count();
  };
  const auto inside = below(request.top);
  const auto wanted = std::min(inside, below(request.bottom) + request.max_modes);
  const double highest = wanted < inside ? dense.values[wanted] : request.top;

  // Pairs beyond those wanted bear the coupling to what lies above; how many of them it takes shows
  // in the bounds.
  constexpr double headroom[] = {1.4, 2};
  constexpr Eigen::Index spare = 4;
  RitzModes out;
  for (const double factor : headroom) {
    const auto count = std::clamp(below(factor * highest), wanted + spare, dense.values.size());
    out = bounded_pairs(mesh, basis, poisson_ratio, dense, count, comm);
    if (out.found.verified_below > highest) break;
  }
  keep(out, std::min<Eigen::Index>(wanted + spare, static_cast<Eigen::Index>(out.lower.size())));
  const bool estimated =
      std::any_of(basis.snapshots.begin(), basis.snapshots.end(),
                  [](const Snapshot& snapshot) { return !snapshot.truth.modes.empty(); });
  if (estimated)
    out.truth = carry_errors(basis, poisson_ratio, out.found.pairs.values, out.coordinates);
  auto& found = out.found;
  found.components = basis.components;
  found.eigen_solver = basis.eigen_solver;
  found.linear_solver = basis.linear_solver;
  found.flexible_below_top = inside;
  const bool to_top = found.verified_below >= request.top * (1 - tightness);
  found.counted = basis.counted && to_top;
  found.all_verified = to_top && wanted == inside;
  return out;
}

}  // namespace carillon::solvers::basis
