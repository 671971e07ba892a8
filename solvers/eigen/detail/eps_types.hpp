#pragma once

#include <slepceps.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "core/handle.hpp"
#include "solvers/eigen/detail/lobpcg.hpp"
#include "solvers/libraries/environment.hpp"

namespace carillon::solvers::eigen {

/// Destroys an EPS but not what its transformation holds: EPSDestroy would take matrices and factor
/// from all who hold the transformation.
void destroy_eps(EPS* eps);
using EpsHandle = core::Handle<EPS, destroy_eps>;

/// Names under which SLEPc knows the eigensolvers of this project (-eps_type).
inline constexpr const char* block_lanczos_type = "blocklanczos";
inline constexpr const char* lobpcg_type = "multigridlobpcg";

/// Makes both types known to SLEPc; may be called any number of times.
void register_eps_types();

/// What block_lanczos() needs to know beside an EPS' own matrices, transformation, dimensions and
/// tolerance. Options: -eps_mpd (or -eps_ncv) vectors kept, -eps_blocklanczos_block columns that go
/// through the operator together.
struct BlockLanczosSpace {
  std::int64_t dimension = 0;  ///< of the space that vectors lie in, of all ranks together
  std::function<void(int number, Eigen::Ref<Eigen::VectorXd> out)> start;  ///< LanczosProblem's
  std::function<void(const Eigen::Ref<const Eigen::MatrixXd>& x, Eigen::Ref<Eigen::MatrixXd> out)>
      mass;  ///< M x
};
/// Does nothing to an EPS of another type, as EPSXxxSet functions do.
void set_space(EPS eps, BlockLanczosSpace space);

/// What an EPS of type lobpcg_type runs, given its tolerance and LobpcgOptions::max_iterations: the
/// preconditioner, the start vectors and the rigid motions that are set apart are the function's
/// own, and monitors hear nothing. Likewise does nothing to another type.
using LobpcgSolve = std::function<LobpcgResult(double tolerance, int max_iterations)>;
void set_solve(EPS eps, LobpcgSolve solve);

}  // namespace carillon::solvers::eigen
