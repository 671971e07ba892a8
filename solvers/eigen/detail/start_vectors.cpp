#include "solvers/eigen/detail/start_vectors.hpp"

namespace carillon::solvers::eigen {
namespace {

double uniform_of(std::uint64_t x) {
  // SplitMix64's finaliser (Steele, Lea and Flood 2014).
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-52 - 1;
}

}  // namespace

void fill_start(const assembly::System& system, std::uint64_t seed, int number,
                Eigen::Ref<Eigen::VectorXd> out) {
  // Vectors lie far apart among the 2^64 numbers that are hashed.
  const auto first = (seed << 40) ^ (static_cast<std::uint64_t>(number) * 0x9e3779b97f4a7c15u);
  for (std::int32_t row = 0; row < system.graph.rows(); ++row) {
    const auto place = static_cast<std::size_t>(system.graph.begin + row);
    const auto node = static_cast<std::uint64_t>(system.partition.node[place]);
    for (std::uint64_t c = 0; c < 3; ++c) {
      out[3 * row + static_cast<Eigen::Index>(c)] = uniform_of(first + 3 * node + c);
    }
  }
  assembly::hold(system, out);
}

Eigen::MatrixXd start_vectors(const assembly::System& system, std::uint64_t seed,
                              Eigen::Index count) {
  Eigen::MatrixXd out(system.owned_unknowns(), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    fill_start(system, seed, static_cast<int>(k), out.col(k));
  }
  return out;
}

}  // namespace carillon::solvers::eigen
