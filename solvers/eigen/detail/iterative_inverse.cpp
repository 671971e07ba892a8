#include "solvers/eigen/detail/iterative_inverse.hpp"

#include <memory>

#include "solvers/assembly/products.hpp"
#include "solvers/eigen/detail/conjugate_gradients.hpp"
#include "solvers/eigen/detail/multigrid.hpp"
#include "solvers/eigen/detail/near_modes.hpp"
#include "solvers/eigen/detail/rigid_solve.hpp"

namespace carillon::solvers::eigen {

ShiftedSystem iterative_shifted(const mesh::TetMesh& mesh,
                                std::span<const elements::Elastic> regions,
                                const assembly::System& system,
                                const std::vector<std::int32_t>& component,
                                const IterativeOptions& options, MPI_Comm comm) {
  const double shift = options.shift;
  ShiftedSystem shifted;
  shifted.shift = shift;
  const auto levels =
      std::make_shared<const Multigrid>(mesh, regions, system, shift, options.factor_bytes, comm);
  const auto rigid = std::make_shared<const RigidSolve>(mesh, system, component, shift, comm);
  const auto products = std::make_shared<const assembly::Products>(system, comm);
  const Inverse product = [products, shift](const Eigen::Ref<const Eigen::MatrixXd>& x,
                                            // Written through:
                                            // NOLINTNEXTLINE(performance-unnecessary-value-param)
                                            Eigen::Ref<Eigen::MatrixXd> out) {
    products->shifted(shift, x, out);
  };
  // Curved elements of a lower order know rotations only nearly, and the energy of rigid motions
  // under K - shift M is next to nothing.
  shifted.preconditioner = [levels, rigid, before_cycle = options.before_cycle](
                               const Eigen::Ref<const Eigen::MatrixXd>& right,
                               // Written through:
                               // NOLINTNEXTLINE(performance-unnecessary-value-param)
                               Eigen::Ref<Eigen::MatrixXd> solution) {
    if (before_cycle) before_cycle();
    levels->cycle(0, right, solution);
    rigid->add(right, solution);
  };
  shifted.near_modes = [levels, shift, comm](int count, std::uint64_t seed) {
    return near_modes(*levels, shift, count, seed, comm);
  };
  shifted.coarse_factor = levels->factor_bytes();
  shifted.rigid = rigid_basis(system, RigidMotions(mesh, system, component), comm);
  const auto& preconditioner = shifted.preconditioner;
  const Inverse inverse =
      [product, preconditioner, rigid, comm, cg = CgOptions{options.tolerance, 2000}](
          const Eigen::Ref<const Eigen::MatrixXd>& right, Eigen::Ref<Eigen::MatrixXd> solution) {
        // Rigid motions answer far more strongly than all else: solved for by themselves, before
        // and after, they leave a tolerance that is relative to the vibrations.
        solution.setZero();
        rigid->add(right, solution);
        Eigen::MatrixXd residual(right.rows(), right.cols()), vibration(right.rows(), right.cols());
        product(solution, residual);
        residual = right - residual;
        conjugate_gradients(product, preconditioner, cg, residual, vibration, comm);
        solution += vibration;
        product(solution, residual);
        residual = right - residual;
        rigid->add(residual, solution);
      };
  shifted.transformation = given_transformation(system, shift, inverse, comm);
  shifted.inverse = inverse_of(shifted.transformation);
  return shifted;
}

}  // namespace carillon::solvers::eigen
