#include "solvers/eigen/detail/near_modes.hpp"

#include <algorithm>

#include "solvers/eigen/detail/lobpcg.hpp"
#include "solvers/eigen/detail/rigid.hpp"
#include "solvers/eigen/detail/start_vectors.hpp"

namespace carillon::solvers::eigen {
namespace {

/// What a coarser level's modes are worth on the next: no more than the levels differ by.
constexpr double rough = 1e-2;
constexpr int max_sweeps = 15;

}  // namespace

Eigen::MatrixXd near_modes(const Multigrid& levels, double shift, int count, std::uint64_t seed,
                           MPI_Comm comm) {
  Eigen::MatrixXd modes;
  for (std::size_t level = levels.levels(); level-- > 0;) {
    const auto& system = levels.system(level);
    const Eigen::MatrixXd carried =
        modes.size() > 0 ? levels.prolong(level, modes) : Eigen::MatrixXd();
    modes = start_vectors(system, seed, count);
    modes.leftCols(carried.cols()) = carried;
    if (level == 0) break;
    const auto parts = mesh::node_components(levels.mesh(level));
    const RigidMotions motions(levels.mesh(level), system, parts);
    const auto rigid = rigid_basis(system, motions, comm);
    const assembly::Products products(system, comm);
    Eigen::MatrixXd mass_rigid(rigid.rows(), rigid.cols());
    products.mass(rigid, mass_rigid);
    const Inverse cycle = [&levels, level](const Eigen::Ref<const Eigen::MatrixXd>& right,
                                           // Written through:
                                           // NOLINTNEXTLINE(performance-unnecessary-value-param)
                                           Eigen::Ref<Eigen::MatrixXd> solution) {
      levels.cycle(level, right, solution);
    };
    const LobpcgProblem problem = {
        &products, system.owned_unknowns(), system.unknowns(), shift, cycle, rigid, mass_rigid,
        comm};
    // A level may have fewer modes than are asked for.
    const auto found = std::min<std::int64_t>(count, system.unknowns() - rigid.cols());
    modes = lobpcg(problem, {static_cast<int>(found), rough, max_sweeps}, modes.leftCols(found))
                .vectors;
  }
  return modes;
}

}  // namespace carillon::solvers::eigen
