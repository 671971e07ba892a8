#pragma once

#include <vector>

#include "solvers/solve_modes.hpp"

namespace carillon::test {

inline const solvers::Elastic steel{2.0e11, 0.29, 7850};
inline const solvers::Elastic glass{6.2e10, 0.20, 2600};
inline const solvers::Elastic aluminium{7.0e10, 0.33, 2700};

/// The lowest flexible modes of a body, one material for each region.
inline solvers::Modes lowest_modes(const solvers::TetMesh& mesh,
                                   const std::vector<solvers::Elastic>& regions, int count,
                                   MPI_Comm comm = MPI_COMM_SELF) {
  core::Trace trace;
  solvers::SolveOptions options;
  options.band = {0, 1e9, count};
  return solve_modes(mesh, regions, options, comm, trace);
}

inline std::vector<double> frequencies(const solvers::Modes& modes) {
  std::vector<double> out;
  for (std::size_t k = 0; k < modes.size(); ++k) out.push_back(modes.frequency(k));
  return out;
}

}  // namespace carillon::test
