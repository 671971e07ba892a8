#include "solvers/search.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "solvers/rigid.hpp"

namespace carillon::solvers {
namespace {

constexpr double target_residual = 1e-8;
constexpr double largest_residual = 1e-6;
/// In the energy norm, whose square bounds the relative error of an eigenvalue: 0.001 cents.
constexpr double largest_energy_residual = 1e-3;
/// Modes asked for beyond those wanted: they show that the wanted ones are the lowest, and give a
/// gap in which to count.
constexpr std::int64_t spare_modes = 4;
constexpr int most_solves = 4;
/// Eigenvalues closer than this (relative) count as one: no shift fits between them safely.
constexpr double smallest_gap = 1e-6;

/// Area of the curved boundary, from its corners: good enough for an estimate.
double corner_area(const TetMesh& mesh) {
  const auto per_face = static_cast<std::size_t>(nodes_per_face(mesh.order));
  SurfaceMesh surface{mesh.nodes, {}};
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto* corner = &mesh.faces[f * per_face];
    surface.triangles.push_back({corner[0], corner[1], corner[2]});
  }
  return area(surface);
}

/// Everything one search needs and learns.
class Search {
 public:
  Search(const TetMesh& mesh, std::span<const Elastic> regions, const SolveOptions& options,
         const System& system, MPI_Comm comm, core::Trace& trace)
      : mesh_(mesh),
        options_(options),
        system_(system),
        comm_(comm),
        trace_(trace),
        component_(node_components(mesh)),
        rigid_(6 * count_components(mesh)),
        estimate_(system.scales.from_frequency(estimate_first_frequency(mesh, regions))),
        bottom_(system.scales.from_frequency(options.band.bottom())),
        top_(system.scales.from_frequency(options.band.max_frequency)) {}

  SearchResult run() {
    result_.components = static_cast<int>(rigid_ / 6);
    // Far below the first mode an inertia count drowns in rounding; no mode is missed by counting
    // higher up.
    counted_at_ = std::max(top_, 0.0025 * estimate_);
    const auto total = count(counted_at_);
    if (total < rigid_) {
      throw core::SolverError(
          fmt::format("{} modes lie below {:.6g} Hz where a free body of {} component(s) has {} "
                      "rigid ones",
                      total, system_.scales.to_frequency(counted_at_), result_.components, rigid_),
          "the mesh may have elements that are nearly flat");
    }
    below_counted_ = total - rigid_;
    result_.flexible_below_top = below_counted_;
    if (below_counted_ == 0) {
      result_.all_verified = true;
      result_.verified_below = top_;
      result_.pairs.vectors.resize(system_.owned_unknowns(), 0);
      return std::move(result_);
    }
    const std::int64_t most = options_.band.max_modes;
    if (below_counted_ > most && counted_at_ > top_) {
      // The estimate was far off: there are modes enough to count at the top itself.
      counted_at_ = top_;
      below_counted_ = std::max<std::int64_t>(0, count(top_) - rigid_);
      result_.flexible_below_top = below_counted_;
    }
    std::int64_t below_band = 0;
    if (below_counted_ > most && bottom_ > 0.1 * estimate_) below_band = count(bottom_) - rigid_;
    solve_until_good(std::min(below_counted_, std::max<std::int64_t>(below_band, 0) + most));
    return std::move(result_);
  }

 private:
  std::int64_t count(double value) {
    const core::ScopedTimer timer(trace_.stages["count"]);
    return count_below(system_, value, comm_);
  }

  /// Solves for so many flexible modes; again with a better shift, more modes or another start
  /// where a check fails.
  void solve_until_good(std::int64_t wanted) {
    // The shift lies a tenth of the first frequency below zero: nearer to zero the factored matrix
    // is nearly singular and residuals grow, further off convergence slows. 20 Hz is a floor for
    // bodies whose first mode is above it.
    const double floor = std::min(system_.scales.from_frequency(20), estimate_);
    double shift = -std::max(0.01 * estimate_, floor);
    std::uint64_t seed = 1;
    bool shift_mended = false;
    for (int solves = 1;; ++solves) {
      solve(wanted, shift, seed);
      const bool may_retry = solves < most_solves;
      const double better_shift = -0.01 * flexible_value(0);
      const double change = better_shift / shift;
      if (worst_residual(wanted) > target_residual && may_retry && (change > 2 || change < 0.5) &&
          !shift_mended) {
        shift = better_shift;
        shift_mended = true;
        continue;
      }
      refuse_bad_residuals(wanted);
      const auto missing = missing_in_band(wanted);
      if (missing > 0 && may_retry) {
        wanted = std::min(below_counted_, wanted + missing);
        continue;
      }
      if (verify(wanted)) return;
      if (!may_retry) break;
      ++seed;
      wanted = std::min(below_counted_, wanted + wanted / 5 + spare_modes);
    }
    result_.verified_below = verified_prefix();
  }

  void solve(std::int64_t wanted, double shift, std::uint64_t seed) {
    const core::ScopedTimer timer(trace_.stages["solve"]);
    const auto pairs = std::min(wanted + rigid_ + spare_modes, system_.unknowns());
    result_.pairs = EigenPairs();
    if (result_.shifted.shift != shift) {
      result_.shifted = ShiftedSystem();  // two factors at once need not fit
      result_.shifted = factor_shifted(system_, shift, comm_);
    }
    result_.pairs = lowest_pairs(system_, {static_cast<int>(pairs), options_.tolerance, seed},
                                 result_.shifted, comm_);
    refuse_mechanism();
    result_.flexible = split_rigid(mesh_, system_, component_, result_.pairs, comm_).flexible;
  }

  /// Parts that share a point or an edge alone swing about it without strain: more zero modes than
  /// rigid ones, in any mixture.
  void refuse_mechanism() const {
    const auto& values = result_.pairs.values;
    const auto zeros = std::count_if(values.begin(), values.end(),
                                     [this](double v) { return v < 1e-9 * estimate_; });
    if (zeros <= rigid_) return;
    throw core::SolverError(
        fmt::format("the body has {} motions without strain beside the {} rigid ones: parts of it "
                    "hang together by a single point or edge",
                    zeros - rigid_, rigid_),
        "join the parts by a face, or separate them");
  }

  double flexible_value(std::size_t k) const {
    return result_.pairs.values[result_.flexible.at(k)];
  }

  double worst_residual(std::int64_t wanted) const {
    double worst = 0;
    const auto count = std::min(static_cast<std::size_t>(wanted), result_.flexible.size());
    for (std::size_t k = 0; k < count; ++k) {
      worst = std::max(worst, result_.pairs.residuals[result_.flexible[k]]);
    }
    return worst;
  }

  void refuse_bad_residuals(std::int64_t wanted) const {
    const auto& pairs = result_.pairs;
    const auto count = std::min(static_cast<std::size_t>(wanted), result_.flexible.size());
    for (std::size_t k = 0; k < count; ++k) {
      const auto i = result_.flexible[k];
      if (pairs.residuals[i] <= largest_residual ||
          pairs.energy_residuals[i] <= largest_energy_residual) {
        continue;
      }
      throw core::SolverError(
          fmt::format("the mode at {:.6g} Hz has a residual of {:.1e} (in the energy norm {:.1e}) "
                      "and should be below {:.0e} ({:.0e})",
                      system_.scales.to_frequency(pairs.values[i]), pairs.residuals[i],
                      pairs.energy_residuals[i], largest_residual, largest_energy_residual),
          "the mesh may have elements that are nearly flat");
    }
  }

  /// How many more must be found because some lie below the band: the bottom was not counted.
  std::int64_t missing_in_band(std::int64_t wanted) const {
    if (wanted >= below_counted_) return 0;
    std::int64_t below = 0;
    for (const auto k : result_.flexible) below += result_.pairs.values[k] < bottom_;
    return std::max<std::int64_t>(0, below + options_.band.max_modes - wanted);
  }

  /// Compares the eigenpairs with inertia counts.
  bool verify(std::int64_t wanted) {
    const auto& values = result_.pairs.values;
    if (wanted >= below_counted_) {
      std::int64_t below = 0, doubtful = 0;
      for (const auto k : result_.flexible) {
        below += values[k] < counted_at_;
        doubtful += std::abs(values[k] / counted_at_ - 1) < 4 * smallest_gap;
      }
      if (std::abs(below - below_counted_) > doubtful) return false;
      result_.all_verified = true;
      result_.verified_below = counted_at_;
      return true;
    }
    for (auto k = static_cast<std::size_t>(wanted); k < result_.flexible.size(); ++k) {
      if (const auto cut = gap_below(k)) {
        const auto modes = count(*cut) - rigid_;
        if (modes != static_cast<std::int64_t>(k)) return false;
        result_.verified_below = *cut;
        return true;
      }
    }
    return false;
  }

  /// A value between flexible modes k - 1 and k, where there is room.
  std::optional<double> gap_below(std::size_t k) const {
    const double low = k == 0 ? 0 : flexible_value(k - 1), high = flexible_value(k);
    if (high - low < smallest_gap * high) return std::nullopt;
    return (low + high) / 2;
  }

  /// The highest gap below which nothing is missing, by bisection. A mode that is missing anywhere
  /// below a gap shows there, so the answer is monotonic.
  double verified_prefix() {
    std::vector<std::pair<std::size_t, double>> gaps;
    for (std::size_t k = 1; k < result_.flexible.size(); ++k) {
      if (const auto cut = gap_below(k)) gaps.emplace_back(k, *cut);
    }
    double good = 0;
    std::size_t low = 0, high = gaps.size();
    while (low < high) {
      const auto middle = (low + high) / 2;
      const auto [modes, cut] = gaps[middle];
      if (count(cut) - rigid_ == static_cast<std::int64_t>(modes)) {
        good = cut;
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return good;
  }

  const TetMesh& mesh_;
  const SolveOptions& options_;
  const System& system_;
  MPI_Comm comm_;
  core::Trace& trace_;
  std::vector<std::int32_t> component_;
  std::int64_t rigid_;
  double estimate_, bottom_, top_;  ///< dimensionless eigenvalues
  double counted_at_ = 0;
  std::int64_t below_counted_ = 0;  ///< flexible modes below counted_at_
  SearchResult result_;
};

}  // namespace

double estimate_first_frequency(const TetMesh& mesh, std::span<const Elastic> regions) {
  double speed = 0;
  for (const auto& region : regions) {
    speed = std::max(speed, std::sqrt(region.youngs_modulus / region.density));
  }
  const double thickness = 2 * measure_quality(mesh).volume / corner_area(mesh);
  const double length = bounding_box(mesh.nodes).longest_side();
  return speed * thickness / (length * length);
}

SearchResult search_modes(const TetMesh& mesh, std::span<const Elastic> regions,
                          const SolveOptions& options, const System& system, MPI_Comm comm,
                          core::Trace& trace) {
  return Search(mesh, regions, options, system, comm, trace).run();
}

}  // namespace carillon::solvers
