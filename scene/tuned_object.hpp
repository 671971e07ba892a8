#pragma once

#include <filesystem>

#include "mpi/comm.hpp"
#include "scene/solved_object.hpp"

namespace carillon::scene {

/// A pitch that an object is made to have by its size.
struct Tuning {
  double frequency = 0;  ///< [Hz], undamped
  int mode = 1;          ///< flexible mode that is at it, counted from the lowest of all
};

/// solve_object() of an object of the request's proportions in another size: every length is
/// multiplied by the one factor (SolvedObject::size) that brings a mode to a pitch. The modes are
/// solved at the request's size, up to where the band then lies, and rescale() is exact: the mode
/// is at the pitch as exactly as numbers are, and as accurate as the solve. Which band that is
/// follows from a first solve of the lowest modes alone, without a pitch target.
/// @throws InputError  a pitch outside the band, fewer modes than asked for, the tuned object
///                     outside 1 mm to 10 m; and as solve_object()
/// @note Collective on comm.
SolvedObject solve_tuned(const ObjectRequest& request, const Tuning& tuning,
                         MPI_Comm comm = MPI_COMM_WORLD, const std::filesystem::path& cache = {});

}  // namespace carillon::scene
