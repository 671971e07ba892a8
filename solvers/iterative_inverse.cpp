#include "solvers/iterative_inverse.hpp"

#include <memory>

#include "solvers/conjugate_gradients.hpp"
#include "solvers/multigrid.hpp"
#include "solvers/products.hpp"

namespace carillon::solvers {

ShiftedSystem iterative_shifted(const TetMesh& mesh, std::span<const Elastic> regions,
                                const System& system, const std::vector<std::int32_t>& component,
                                double shift, std::int64_t factor_bytes, MPI_Comm comm) {
  ShiftedSystem shifted;
  shifted.shift = shift;
  shifted.matrix = shifted_product(system, shift, comm);
  shifted.mass = mass_matrix(system, comm);
  const auto cycle = multigrid_cycle(mesh, regions, system, component, shift, factor_bytes, comm);
  const auto products = std::make_shared<const Products>(system, comm);
  const Inverse product = [products, shift](const Eigen::Ref<const Eigen::MatrixXd>& x,
                                            Eigen::Ref<Eigen::MatrixXd> out) {
    products->shifted(shift, x, out);
  };
  shifted.inverse = [product, cycle, comm](const Eigen::Ref<const Eigen::MatrixXd>& right,
                                           Eigen::Ref<Eigen::MatrixXd> solution) {
    conjugate_gradients(product, cycle, {}, right, solution, comm);
  };
  shifted.preconditioner = cycle;
  return shifted;
}

}  // namespace carillon::solvers
