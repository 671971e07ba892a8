#pragma once

#include <vector>

#include "solvers/eigen/solve_modes.hpp"
#include "solvers/elements/anisotropy.hpp"

namespace carillon::test {

inline const solvers::elements::Elastic steel{2.0e11, 0.29, 7850};
inline const solvers::elements::Elastic glass{6.2e10, 0.20, 2600};
inline const solvers::elements::Elastic aluminium{7.0e10, 0.33, 2700};
/// Sitka spruce, about (Wood Handbook, tables 5-1 to 5-3): axes along the grain, across the rings,
/// along them.
inline const solvers::elements::EngineeringConstants spruce{
    {11.9e9, 0.93e9, 0.51e9}, {0.435, 0.467, 0.372}, {0.036e9, 0.73e9, 0.76e9}};

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
