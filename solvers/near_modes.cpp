#include "solvers/near_modes.hpp"

#include "solvers/lobpcg.hpp"
#include "solvers/rigid.hpp"
#include "solvers/start_vectors.hpp"

namespace carillon::solvers {
namespace {

/// What a coarser level's modes are worth on the next: no more than the levels differ by.
constexpr LobpcgOptions rough = {0, 1e-2, 15};

}  // namespace

Eigen::MatrixXd near_modes(const Multigrid& levels, double shift, int count, std::uint64_t seed,
                           MPI_Comm comm) {
  Eigen::MatrixXd modes;
  for (std::size_t level = levels.levels(); level-- > 0;) {
    const auto& system = levels.system(level);
    const Eigen::MatrixXd carried =
        modes.size() > 0 ? levels.prolong(level, modes) : Eigen::MatrixXd();
    // A level may have fewer modes than are asked for.
    modes = start_vectors(system, seed, count);
    modes.leftCols(carried.cols()) = carried;
    if (level == 0) break;
    const auto parts = node_components(levels.mesh(level));
    const auto rigid =
        rigid_basis(system, RigidMotions(levels.mesh(level), system.scales, parts), comm);
    const Products products(system, comm);
    Eigen::MatrixXd mass_rigid(rigid.rows(), rigid.cols());
    products.mass(rigid, mass_rigid);
    LobpcgOptions options = rough;
    options.pairs = count;
    const Inverse cycle = [&levels, level](const Eigen::Ref<const Eigen::MatrixXd>& right,
                                           Eigen::Ref<Eigen::MatrixXd> solution) {
      levels.cycle(level, right, solution);
    };
    modes = lobpcg({&products, system.owned_unknowns(), system.unknowns(), shift, cycle, rigid,
                    mass_rigid, comm},
                   options, modes)
                .vectors;
  }
  return modes;
}

}  // namespace carillon::solvers
