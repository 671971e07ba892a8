#pragma once

#include <vector>

#include "solvers/eigen/solve_modes.hpp"

namespace carillon::test {

inline const solvers::elements::Elastic steel{2.0e11, 0.29, 7850};
inline const solvers::elements::Elastic glass{6.2e10, 0.20, 2600};
inline const solvers::elements::Elastic aluminium{7.0e10, 0.33, 2700};

/// The lowest flexible modes of a body, one material for each region.
inline solvers::modes::Modes lowest_modes(const solvers::mesh::TetMesh& mesh,
                                          const std::vector<solvers::elements::Elastic>& regions,
                                          int count, MPI_Comm comm = MPI_COMM_SELF) {
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  options.band = {0, 1e9, count};
  return solvers::eigen::solve_modes(mesh, regions, options, comm, trace);
}

inline std::vector<double> frequencies(const solvers::modes::Modes& modes) {
  std::vector<double> out;
  for (std::size_t k = 0; k < modes.size(); ++k) out.push_back(modes.frequency(k));
  return out;
}

}  // namespace carillon::test
