#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "solvers/assembly/assemble.hpp"

namespace carillon::solvers::eigen {

/// Random vector by mesh node, so that it is the same however the nodes are spread over ranks.
/// @param number  of the vector, in an endless row of them
/// @param out     owned unknowns
void fill_start(const assembly::System& system, std::uint64_t seed, int number,
                Eigen::Ref<Eigen::VectorXd> out);

/// The first of the row: owned unknowns x count.
Eigen::MatrixXd start_vectors(const assembly::System& system, std::uint64_t seed,
                              Eigen::Index count);

}  // namespace carillon::solvers::eigen
