#include "solvers/eigen/detail/probe.hpp"

#include <algorithm>
#include <limits>

#include "solvers/assembly/products.hpp"
#include "solvers/eigen/detail/lobpcg.hpp"
#include "solvers/eigen/detail/start_vectors.hpp"

namespace carillon::solvers::eigen {
namespace {

/// As wide as products and factors work best.
constexpr Eigen::Index width = 8;
/// The lowest value to about a thousandth.
constexpr double tolerance = 0.03;
constexpr int max_iterations = 40;

}  // namespace

double lowest_beside(const EigenPairs& pairs, const assembly::System& system,
                     const ShiftedSystem& shifted, std::uint64_t seed, MPI_Comm comm) {
  const auto room = system.free_unknowns() - pairs.size();
  if (room < 1) return std::numeric_limits<double>::infinity();
  const assembly::Products products(system, comm);
  const LobpcgProblem problem = {&products,
                                 system.owned_unknowns(),
                                 system.unknowns(),
                                 shifted.shift,
                                 shifted.preconditioner,
                                 pairs.vectors,
                                 pairs.mass_vectors,
                                 comm};
  // Others than those that an eigensolver of the same seed began with.
  const auto start = start_vectors(system, ~seed, std::min<Eigen::Index>(width, room));
  return lobpcg(problem, {1, tolerance, max_iterations}, start).values[0];
}

}  // namespace carillon::solvers::eigen
