#include "solvers/eigen/detail/finer_factor.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "mpi/comm.hpp"

namespace carillon::solvers::eigen {

bool is_flat(const mesh::TetMesh& mesh) {
  constexpr double wide = 6, many = 0.1;
  double flat = 0, all = 0;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto at = [&](std::size_t i) -> const Vec3& {
      return mesh.nodes[static_cast<std::size_t>(mesh.element(e)[i])];
    };
    double longest = 0, largest = 0;  // edge, twice a face's area
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 a = at((i + 1) % 4) - at(i), b = at((i + 2) % 4) - at(i);
      longest = std::max({longest, a.norm(), b.norm()});
      largest = std::max(largest, a.cross(b).norm());
    }
    const Vec3 a = at(1) - at(0), b = at(2) - at(0), c = at(3) - at(0);
    const double altitude = std::abs(a.cross(b).dot(c)) / largest;
    const double volume = altitude * largest;  // six times
    all += volume;
    if (longest > wide * altitude) flat += volume;
  }
  return flat > many * all;
}

std::optional<FinerFactor> FinerFactor::make(const FinerSpace& space,
                                             std::span<const elements::Elastic> regions,
                                             const assembly::MirrorClass& mirror, double shift,
                                             std::int64_t memory, MPI_Comm comm) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  assembly::Partition part;
  mpi::agreed_in_group(comm, [&] { part = assembly::partition(space.mesh(), ranks); });
  const auto system = std::make_shared<const assembly::System>(
      assembly::assemble(space.mesh(), regions, std::move(part), comm, mirror));
  const auto plan = plan_factors(*system, comm);
  if (predict_factor(*system, FactorPurpose::solve, plan, comm).bytes > memory) {
    return std::nullopt;
  }
  FinerFactor out;
  out.system_ = system;
  out.inverse_ = factored_inverse(*system, shift, plan, comm);
  return out;
}

void FinerFactor::add(const Fields& residual, Fields& out) const {
  const Eigen::MatrixXd right = owned_rows(*system_, residual);
  Eigen::MatrixXd solution(right.rows(), right.cols());
  inverse_(right, solution);
  add_owned(*system_, solution, out);
}

}  // namespace carillon::solvers::eigen
