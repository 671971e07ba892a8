#pragma once

#include <mpi.h>

#include "solvers/eigen/eigen_solve.hpp"

namespace carillon::solvers::eigen {

/// Every eigenpair of K x = lambda M x between two positive values, by spectrum slicing:
/// shift-invert at several shifts inside, counted by inertia until none is missing (Campos and
/// Roman 2012, Numer. Algorithms 60, 279). Dearer by the mode than lowest_pairs(), but it notices
/// when it has lost one. values and vectors alone are filled.
///
/// @param low, high  dimensionless, in gaps between eigenvalues; low is above the rigid modes
/// @throws core::SolverError  no convergence, or a factorisation failed
/// @note Collective on comm.
EigenPairs slice_spectrum(const assembly::System& system, double low, double high, double tolerance,
                          MPI_Comm comm);

}  // namespace carillon::solvers::eigen
