#pragma once

#include <span>
#include <vector>

#include "scene/solved_object.hpp"

namespace carillon::scene {

/// Modes of an object at several Poisson's ratios, on one mesh.
struct PoissonSets {
  std::vector<double> poisson_ratios;        ///< ascending
  std::vector<solvers::modes::Modes> modes;  ///< one set for each
  std::vector<std::string> warnings;         ///< as SolvedObject::warnings
  core::Trace trace;
};

/// solve_object() for every Poisson's ratio in turn, by as few eigensolves as solve_materials()
/// takes. A pitch target chooses the mesh by the request's own ratio; of bodies of revolution every
/// set meets it.
/// @param request  of one material, whose Poisson's ratio is replaced
/// @param ratios   ascending; one or more
/// @throws InputError  several regions; and as solve_object()
/// @note Collective on comm.
PoissonSets solve_poisson_ratios(const ObjectRequest& request, std::span<const double> ratios,
                                 MPI_Comm comm, const std::filesystem::path& cache = {});

}  // namespace carillon::scene
