#pragma once

#include <mpi.h>

#include <filesystem>
#include <span>
#include <vector>

#include "core/trace.hpp"
#include "solvers/eigen/solve_modes.hpp"

namespace carillon::solvers::basis {

/// What one material (or several of equal Poisson's ratio) asks of a shape.
struct ModeRequest {
  std::vector<elements::Elastic> regions;  ///< one for each of the mesh's region_names
  modes::Band band;
};

/// Requests served together. With snapshots: modes at these Poisson's ratios span a basis for all
/// of them. Without: each is solved on its own.
struct SolveGroup {
  std::vector<std::size_t> requests;
  std::vector<double> snapshots;  ///< Poisson's ratios, ascending

  std::size_t solves() const { return snapshots.empty() ? requests.size() : snapshots.size(); }
};

/// Which eigensolves serve a list of requests.
///
/// One basis of three snapshots (two where the ratios lie within 0.12 of each other) serves every
/// request whose regions share one Poisson's ratio between 0 and 0.46 and the same contrasts of
/// moduli and densities; up to three requests are no dearer alone. A basis must hold the modes of
/// the request that has most: requests are split by how many they are expected to have
/// (expected_modes, max_modes) where that saves more than a third.
///
/// The three ratios are 0.10, 0.30 and 0.44 whatever is asked for, so that a material's modes
/// hardly depend on which others there are.
std::vector<SolveGroup> plan_solves(const mesh::TetMesh& mesh,
                                    std::span<const ModeRequest> requests);

/// Modes to expect below a frequency [Hz], to a factor of 2.5: bending and in-plane waves of
/// a plate of the body's volume [m^3] and mean thickness [m], and waves in its volume (asymptotic
/// mode counts: Lyon and DeJong 1995, Theory and Application of Statistical Energy Analysis).
double expected_modes(double volume, double thickness, const elements::Elastic& elastic,
                      double frequency);

/// Modes of one shape in several materials: solve_modes() of every request, by as few eigensolves
/// as plan_solves() says. Modes from a basis are certified: every frequency lies within
/// certificate.basis_error of that of a solve of its own, at most 0.1 cents, and completeness is
/// proved as far as the certificate says. A request that cannot be certified is solved on its own.
///
/// @param options  its band is not used
/// @param cache    folder of files by content; "" for none
/// @param trace    beside the stages of solve_modes: "basis" (joining snapshots), "ritz" (requests
///                 served from a basis), "solved apart" (requests that could not be)
/// @return one for each request
/// @throws as solve_modes
/// @note Collective on comm.
std::vector<modes::Modes> solve_materials(const mesh::TetMesh& mesh,
                                          std::span<const ModeRequest> requests,
                                          const eigen::SolveOptions& options, MPI_Comm comm,
                                          const std::filesystem::path& cache, core::Trace& trace);

}  // namespace carillon::solvers::basis
