#include "solvers/eigen/search.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "solvers/eigen/detail/iterative_inverse.hpp"
#include "solvers/eigen/detail/memory_gate.hpp"
#include "solvers/eigen/detail/probe.hpp"
#include "solvers/eigen/detail/rigid.hpp"
#include "solvers/eigen/search_checks.hpp"

namespace carillon::solvers::eigen {
namespace {

/// Modes asked for beyond those wanted: they show that the wanted ones are the lowest, and give a
/// gap in which to count.
constexpr std::int64_t spare_modes = 4;
/// Solves for more modes, before a set is judged as it is.
constexpr int max_solves = 4;
/// Tolerance of the eigensolver where linear solves are iterative, and what they need of it.
constexpr double tightest_iterative = 1e-10, inner_fraction = 0.01;
/// Modes asked for at first where they cannot be counted before.
constexpr std::int64_t first_batch = 20;
/// An eigenvalue this close (relative) to where modes were counted may lie on either side of it.
constexpr double count_margin = 4e-6;

/// sqrt(E / rho) [m/s] with E and rho averaged over the body: E by the mean compliance, since the
/// soft parts are the ones that bend while the heavy ones load them.
double mean_wave_speed(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions) {
  std::vector<double> volumes(regions.size(), 0.0);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    volumes[static_cast<std::size_t>(mesh.regions[e])] += std::abs(mesh::six_volumes(mesh, e));
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
  Search(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
         const SolveOptions& options, const assembly::System& system, MPI_Comm comm,
         core::Trace& trace, const SearchMethods& methods)
      : mesh_(mesh),
        regions_(regions),
        options_(options),
        system_(system),
        comm_(comm),
        trace_(trace),
        methods_(methods),
        component_(mesh::node_components(mesh)),
        components_(mesh::count_components(mesh)),
        rigid_(std::ssize(system.mirror.rigid_motions()) * components_),
        estimate_(system.scales.from_frequency(
            estimate_first_frequency(mesh, regions, system.mirror.box.longest_side()))),
        bottom_(system.scales.from_frequency(options.band.bottom())),
        top_(system.scales.from_frequency(options.band.max_frequency)) {}

  SearchResult run() {
    result_.components = components_;
    choose_solver();
    if (memory_.counts) {
      find_counted();
    } else {
      find_uncounted();
    }
    // What follows a search may need the factor that a count took the place of.
    if (result_.pairs.size() > 0) prepare();
    return std::move(result_);
  }

 private:
  /// Analyses the factors and decides which of them are made.
  void choose_solver() {
    if (options_.linear_solver != modes::LinearSolver::iterative) {
      const core::ScopedTimer timer(trace_.stages["order"]);
      plan_ = plan_factors(system_, comm_);
    }
    const core::ScopedTimer timer(trace_.stages["order"]);
    const auto first_pairs =
        pairs_for(std::min<std::int64_t>(options_.band.max_modes, first_batch));
    needs_ = memory_needs(mesh_, system_, options_, plan_, first_pairs, comm_);
    memory_ = decide(needs_, options_.linear_solver, options_.memory_limit);
    result_.eigen_solver = options_.solver;
    result_.linear_solver = memory_.linear_solver;
    result_.counted = memory_.counts;
  }

  /// Of the eigensolver. One that is fed by an inexact inverse cannot see below its error.
  double tolerance() const {
    const bool iterative = memory_.linear_solver == modes::LinearSolver::iterative;
    return iterative ? std::max(options_.tolerance, tightest_iterative) : options_.tolerance;
  }

  std::int64_t pairs_for(std::int64_t wanted) const {
    return std::min(wanted + rigid_ + spare_modes + more_, system_.free_unknowns());
  }

  /// Ends the solve on every rank once the first one's clock has passed the limit; empty where
  /// there is none. Refers to nothing of this search.
  std::function<void()> clock() const {
    if (!options_.time.is_set()) return {};
    return [comm = comm_, limit = options_.time] {
      int passed = limit.passed() ? 1 : 0;
      MPI_Bcast(&passed, 1, MPI_INT, 0, comm);
      if (passed != 0) limit.refuse();
    };
  }

  void heed_time() const {
    if (const auto look = clock()) look();
  }

  std::int64_t count(double value) {
    heed_time();
    const core::ScopedTimer timer(trace_.stages["count"]);
    if (!memory_.both_fit) result_.shifted = ShiftedSystem();
    return count_below(system_, value, plan_, comm_);
  }

  Count counter() {
    return [this](double value) { return count(value); };
  }

  /// Counts the band's modes first, finds so many or as many as are wanted, and compares.
  void find_counted() {
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
      return;
    }
    const std::int64_t maximum = options_.band.max_modes;
    if (below_counted_ > maximum && counted_at_ > top_) {
      // The estimate was far off: there are modes enough to count at the top itself.
      counted_at_ = top_;
      below_counted_ = std::max<std::int64_t>(0, count(top_) - rigid_);
      result_.flexible_below_top = below_counted_;
    }
    std::int64_t below_band = 0;
    if (below_counted_ > maximum && bottom_ > 0.1 * estimate_) below_band = count(bottom_) - rigid_;
    auto wanted = std::min(below_counted_, std::max<std::int64_t>(below_band, 0) + maximum);
    wanted = solve_for_band(wanted);
    if (verify(wanted)) return;
    // Another start, in a larger space: what one vector happened to miss another holds.
    ++seed_;
    more_ = wanted / 5 + spare_modes;
    wanted = solve_for_band(std::min(below_counted_, wanted + more_));
    if (verify(wanted)) return;
    if (fill_lacks(wanted) && verify(wanted)) return;
    result_.verified_below = verified_prefix(result_, rigid_, counter());
  }

  /// Without inertia: solves for more and more modes until some lie above the band or enough within
  /// it, then looks beside them for any that were lost.
  void find_uncounted() {
    std::int64_t wanted = std::min<std::int64_t>(options_.band.max_modes, first_batch);
    for (int attempt = 0; attempt < 2; ++attempt, ++seed_) {
      while (true) {
        solve_well(wanted);
        const auto enough = found_below(bottom_) + options_.band.max_modes;
        if (highest() > top_ || wanted >= enough || all_found()) break;
        // Modes crowd as f^1 (plates) to f^3 (solids); more than enough costs less than once more.
        const double fraction = std::pow(top_ / highest(), 0.75);
        const double guess = std::clamp(1.2 * fraction, 1.5, 4.0) * static_cast<double>(wanted);
        wanted = std::min(enough, static_cast<std::int64_t>(guess));
      }
      double beside = 0;
      mpi::agreed_in_group(comm_, [&] {
        beside = lowest_beside(result_.pairs, system_, result_.shifted, seed_, comm_);
      });
      if (all_found() || beside > highest() * (1 - 1e-6)) {
        result_.all_verified = highest() > top_ || all_found();
        result_.flexible_below_top = found_below(top_);
        result_.verified_below = result_.all_verified ? top_ : highest();
        return;
      }
      wanted += wanted / 5 + spare_modes;
    }
    // Something stays lost, and nothing says where.
    result_.flexible_below_top = found_below(top_) + 1;
  }

  double highest() const { return flexible_value(result_, result_.flexible.size() - 1); }

  bool all_found() const { return result_.pairs.size() == system_.free_unknowns(); }

  std::int64_t found_below(double value) const {
    return std::count_if(result_.flexible.begin(), result_.flexible.end(),
                         [&](std::size_t k) { return result_.pairs.values[k] < value; });
  }

  /// Solves for so many flexible modes, and for more when those turn out to lie below the band.
  /// @return how many were wanted in the end
  std::int64_t solve_for_band(std::int64_t wanted) {
    for (int solves = 1;; ++solves) {
      solve_well(wanted);
      if (wanted >= below_counted_ || solves == max_solves) return wanted;
      // The band's bottom was not counted: what was found tells how many lie below it.
      const auto missing = found_below(bottom_) + options_.band.max_modes - wanted;
      if (missing <= 0) return wanted;
      wanted = std::min(below_counted_, wanted + missing);
    }
  }

  /// Solves for so many flexible modes; once more with a better shift where residuals ask for it.
  void solve_well(std::int64_t wanted) {
    // The shift lies a tenth of the first frequency below zero: nearer to zero the factored matrix
    // is nearly singular and residuals grow, further off convergence slows. 20 Hz is a floor for
    // bodies whose first mode is above it.
    const double floor = std::min(system_.scales.from_frequency(20), estimate_);
    if (shift_ == 0) shift_ = -std::max(0.01 * estimate_, floor);
    solve(wanted);
    const double better_shift = -0.01 * flexible_value(result_, 0);
    const double change = better_shift / shift_;
    const bool direct = memory_.linear_solver == modes::LinearSolver::direct;
    if (direct && worst_residual(result_, wanted) > target_residual &&
        (change > 2 || change < 0.5) && !shift_mended_) {
      shift_ = better_shift;
      shift_mended_ = true;
      solve(wanted);
    }
    refuse_bad_residuals(result_, wanted, system_.scales);
  }

  void solve(std::int64_t wanted) {
    const core::ScopedTimer timer(trace_.stages["solve"]);
    const auto pairs = pairs_for(wanted);
    // The basis was counted for a first few pairs before there was a number.
    weigh_vectors(system_, pairs, needs_);
    refuse_large_basis(needs_, memory_, options_.memory_limit);
    make_room();
    result_.spare_memory = left_for_estimates(needs_, memory_, options_.memory_limit);
    EigenRequest request{static_cast<int>(pairs), tolerance(), seed_, options_.solver};
    // Another seed is to find what these may have missed.
    if (memory_.linear_solver == modes::LinearSolver::iterative && solved_seed_ == seed_) {
      request.start = result_.pairs.vectors(Eigen::all, result_.flexible);
    }
    solved_seed_ = seed_;
    result_.pairs = EigenPairs();
    prepare();
    mpi::agreed_in_group(
        comm_, [&] { result_.pairs = methods_.lowest(system_, request, result_.shifted, comm_); });
    result_.eigen_solver = result_.pairs.solver;
    judge();
  }

  /// A coarser level's factor gives way to more vectors.
  void make_room() {
    if (memory_.linear_solver != modes::LinearSolver::iterative) return;
    memory_.coarse_factor = room_for_coarse(needs_, options_.memory_limit);
    if (result_.shifted.coarse_factor > memory_.coarse_factor) result_.shifted = ShiftedSystem();
  }

  /// Makes K - shift M ready to solve with, unless it is.
  void prepare() {
    if (result_.shifted.inverse && result_.shifted.shift == shift_) return;
    result_.shifted = ShiftedSystem();  // two factors at once need not fit
    heed_time();
    if (memory_.linear_solver == modes::LinearSolver::direct) {
      result_.shifted = factor_shifted(system_, shift_, plan_, comm_, clock());
    } else {
      const IterativeOptions options{shift_, inner_fraction * tolerance(), memory_.coarse_factor,
                                     clock()};
      result_.shifted = iterative_shifted(mesh_, regions_, system_, component_, options, comm_);
    }
  }

  /// Tells vibrations from rigid motions among the pairs.
  void judge() {
    refuse_mechanism(result_.pairs, rigid_, estimate_);
    result_.flexible = split_rigid(mesh_, system_, component_, result_.pairs, comm_).flexible;
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
    if (!slices_fit(needs_, options_.memory_limit)) return false;
    const auto lacks = find_lacks(result_, rigid_, top, counter());
    if (lacks.empty()) return false;
    const core::ScopedTimer timer(trace_.stages["slice"]);
    result_.shifted = ShiftedSystem();
    std::vector<EigenPairs> slices;
    for (const auto& lack : lacks) {
      heed_time();
      slices.push_back(methods_.slice(system_, lack.low, lack.high, options_.tolerance, comm_));
    }
    result_.pairs = with_slices(result_, lacks, slices);
    prepare();
    measure(system_, result_.shifted, comm_, result_.pairs);
    judge();
    refuse_bad_residuals(result_, wanted, system_.scales);
    return true;
  }

  const mesh::TetMesh& mesh_;
  std::span<const elements::Elastic> regions_;
  const SolveOptions& options_;
  const assembly::System& system_;
  MPI_Comm comm_;
  core::Trace& trace_;
  const SearchMethods& methods_;
  FactorPlan plan_;
  MemoryNeeds needs_;
  MemoryDecision memory_;
  std::vector<std::int32_t> component_;
  int components_;
  std::int64_t rigid_;
  double estimate_, bottom_, top_;  ///< dimensionless eigenvalues
  double counted_at_ = 0;
  std::int64_t below_counted_ = 0;  ///< flexible modes below counted_at_
  double shift_ = 0;
  bool shift_mended_ = false;
  std::uint64_t seed_ = 1;         ///< of the start vector
  std::uint64_t solved_seed_ = 0;  ///< of the pairs that are there
  std::int64_t more_ = 0;          ///< pairs beyond those wanted, once a mode was missing
  SearchResult result_;
};

}  // namespace

double estimate_first_frequency(const mesh::TetMesh& mesh,
                                std::span<const elements::Elastic> regions, double length) {
  if (length == 0) length = mesh::bounding_box(mesh.nodes).longest_side();
  return mean_wave_speed(mesh, regions) * mesh::mean_thickness(mesh) / (length * length);
}

SearchResult search_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                          const SolveOptions& options, const assembly::System& system,
                          MPI_Comm comm, core::Trace& trace, const SearchMethods& methods) {
  return Search(mesh, regions, options, system, comm, trace, methods).run();
}

}  // namespace carillon::solvers::eigen
