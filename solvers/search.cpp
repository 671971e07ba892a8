#include "solvers/search.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "solvers/rigid.hpp"
#include "solvers/search_checks.hpp"

namespace carillon::solvers {
namespace {

constexpr double target_residual = 1e-8;
/// Modes asked for beyond those wanted: they show that the wanted ones are the lowest, and give a
/// gap in which to count.
constexpr std::int64_t spare_modes = 4;
/// Solves with a better shift or more modes, before a set is judged as it is.
constexpr int most_solves = 4;
/// An eigenvalue this close (relative) to where modes were counted may lie on either side of it.
constexpr double count_margin = 4e-6;

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

/// sqrt(E / rho) [m/s] with E and rho averaged over the body: E by the mean compliance, since the
/// soft parts are the ones that bend while the heavy ones load them.
double mean_wave_speed(const TetMesh& mesh, std::span<const Elastic> regions) {
  std::vector<double> volumes(regions.size(), 0.0);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto corner = [&](std::size_t i) -> const Vec3& {
      return mesh.nodes[static_cast<std::size_t>(mesh.element(e)[i])];
    };
    volumes[static_cast<std::size_t>(mesh.regions[e])] +=
        std::abs((corner(1) - corner(0)).cross(corner(2) - corner(0)).dot(corner(3) - corner(0)));
  }
  double compliance = 0, mass = 0, volume = 0;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    volume += volumes[r];
    compliance += volumes[r] / regions[r].youngs_modulus;
    mass += volumes[r] * regions[r].density;
  }
  return volume / std::sqrt(compliance * mass);
}

/// Everything one search needs and learns.
class Search {
 public:
  Search(const TetMesh& mesh, std::span<const Elastic> regions, const SolveOptions& options,
         const System& system, MPI_Comm comm, core::Trace& trace, const SearchMethods& methods)
      : mesh_(mesh),
        options_(options),
        system_(system),
        comm_(comm),
        trace_(trace),
        methods_(methods),
        component_(node_components(mesh)),
        rigid_(6 * count_components(mesh)),
        estimate_(system.scales.from_frequency(estimate_first_frequency(mesh, regions))),
        bottom_(system.scales.from_frequency(options.band.bottom())),
        top_(system.scales.from_frequency(options.band.max_frequency)) {}

  SearchResult run() {
    result_.components = static_cast<int>(rigid_ / 6);
    result_.counted = true;
    {
      const core::ScopedTimer timer(trace_.stages["order"]);
      plan_ = plan_factors(system_, comm_);
    }
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
    find_counted(std::min(below_counted_, std::max<std::int64_t>(below_band, 0) + most));
    return std::move(result_);
  }

 private:
  std::int64_t count(double value) {
    const core::ScopedTimer timer(trace_.stages["count"]);
    return count_below(system_, value, plan_, comm_);
  }

  Count counter() {
    return [this](double value) { return count(value); };
  }

  /// Finds so many flexible modes, and compares them with inertia.
  void find_counted(std::int64_t wanted) {
    wanted = solve_until_good(wanted);
    if (verify(wanted)) return;
    // Another start, in a larger space: what one vector happened to miss another holds.
    ++seed_;
    const auto more = std::min(below_counted_, wanted + wanted / 5 + spare_modes);
    wanted = solve_until_good(more);
    if (verify(wanted)) return;
    if (fill_lacks(wanted) && verify(wanted)) return;
    result_.verified_below = verified_prefix(result_, rigid_, counter());
  }

  /// Solves for so many flexible modes; again with a better shift or for more where that is needed.
  /// @return how many were wanted in the end
  std::int64_t solve_until_good(std::int64_t wanted) {
    // The shift lies a tenth of the first frequency below zero: nearer to zero the factored matrix
    // is nearly singular and residuals grow, further off convergence slows. 20 Hz is a floor for
    // bodies whose first mode is above it.
    const double floor = std::min(system_.scales.from_frequency(20), estimate_);
    if (shift_ == 0) shift_ = -std::max(0.01 * estimate_, floor);
    for (int solves = 1;; ++solves) {
      solve(wanted);
      const bool may_retry = solves < most_solves;
      const double better_shift = -0.01 * flexible_value(result_, 0);
      const double change = better_shift / shift_;
      if (worst_residual(result_, wanted) > target_residual && may_retry &&
          (change > 2 || change < 0.5) && !shift_mended_) {
        shift_ = better_shift;
        shift_mended_ = true;
        continue;
      }
      refuse_bad_residuals(result_, wanted, system_.scales);
      const auto missing = missing_in_band(wanted);
      if (missing == 0 || !may_retry) return wanted;
      wanted = std::min(below_counted_, wanted + missing);
    }
  }

  void solve(std::int64_t wanted) {
    const core::ScopedTimer timer(trace_.stages["solve"]);
    const auto pairs = std::min(wanted + rigid_ + spare_modes, system_.unknowns());
    result_.pairs = EigenPairs();
    prepare();
    result_.pairs = methods_.lowest(
        system_, {static_cast<int>(pairs), options_.tolerance, seed_, options_.solver},
        result_.shifted, comm_);
    judge();
  }

  /// Makes K - shift M ready to solve with, unless it is.
  void prepare() {
    if (result_.shifted.inverse && result_.shifted.shift == shift_) return;
    result_.shifted = ShiftedSystem();  // two factors at once need not fit
    result_.shifted = factor_shifted(system_, shift_, plan_, comm_);
  }

  /// Tells vibrations from rigid motions among the pairs.
  void judge() {
    refuse_mechanism(result_.pairs, rigid_, estimate_);
    result_.flexible = split_rigid(mesh_, system_, component_, result_.pairs, comm_).flexible;
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
        doubtful += std::abs(values[k] / counted_at_ - 1) < count_margin;
      }
      if (std::abs(below - below_counted_) > doubtful) return false;
      result_.all_verified = true;
      result_.verified_below = counted_at_;
      return true;
    }
    const auto cut = cut_above(wanted);
    if (!cut || count(cut->value) - rigid_ != cut->modes) return false;
    result_.verified_below = cut->value;
    return true;
  }

  struct Cut {
    double value;
    std::int64_t modes;  ///< flexible ones that were found below
  };

  /// The lowest gap above the wanted modes.
  std::optional<Cut> cut_above(std::int64_t wanted) const {
    for (auto k = static_cast<std::size_t>(wanted); k < result_.flexible.size(); ++k) {
      if (const auto value = gap_below(result_, k)) {
        return Cut{*value, static_cast<std::int64_t>(k)};
      }
    }
    return std::nullopt;
  }

  /// Third attempt: slices the spectrum where modes are missing, and takes what is there.
  /// @return whether anything was sliced
  bool fill_lacks(std::int64_t wanted) {
    double top = counted_at_;
    if (wanted < below_counted_) {
      // So many may be missing that no gap above the wanted ones was seen; the highest one serves.
      auto cut = cut_above(wanted);
      for (auto k = wanted; !cut && k > 0; --k) cut = cut_above(k - 1);
      if (!cut) return false;
      top = cut->value;
    }
    const auto lacks = find_lacks(result_, rigid_, top, counter());
    if (lacks.empty()) return false;
    const core::ScopedTimer timer(trace_.stages["slice"]);
    result_.shifted = ShiftedSystem();
    std::vector<EigenPairs> slices;
    for (const auto& lack : lacks) {
      slices.push_back(methods_.slice(system_, lack.low, lack.high, options_.tolerance, comm_));
    }
    result_.pairs = with_slices(result_, lacks, slices);
    prepare();
    measure(system_, result_.shifted, comm_, result_.pairs);
    judge();
    refuse_bad_residuals(result_, wanted, system_.scales);
    return true;
  }

  const TetMesh& mesh_;
  const SolveOptions& options_;
  const System& system_;
  MPI_Comm comm_;
  core::Trace& trace_;
  const SearchMethods& methods_;
  FactorPlan plan_;
  std::vector<std::int32_t> component_;
  std::int64_t rigid_;
  double estimate_, bottom_, top_;  ///< dimensionless eigenvalues
  double counted_at_ = 0;
  std::int64_t below_counted_ = 0;  ///< flexible modes below counted_at_
  double shift_ = 0;
  bool shift_mended_ = false;
  std::uint64_t seed_ = 1;  ///< of the start vector
  SearchResult result_;
};

}  // namespace

double estimate_first_frequency(const TetMesh& mesh, std::span<const Elastic> regions) {
  const double thickness = 2 * measure_quality(mesh).volume / corner_area(mesh);
  const double length = bounding_box(mesh.nodes).longest_side();
  return mean_wave_speed(mesh, regions) * thickness / (length * length);
}

SearchResult search_modes(const TetMesh& mesh, std::span<const Elastic> regions,
                          const SolveOptions& options, const System& system, MPI_Comm comm,
                          core::Trace& trace, const SearchMethods& methods) {
  return Search(mesh, regions, options, system, comm, trace, methods).run();
}

}  // namespace carillon::solvers
