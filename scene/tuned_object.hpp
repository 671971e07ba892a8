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

/// Frequency [Hz] of a mode of a request's object at the request's size, by a solve of the lowest
/// modes alone without a pitch target: a first estimate for whoever tunes it.
/// @param mode  counted from 1, the lowest
/// @param trace  what the solve took is added
/// @throws InputError  there is no such mode; and as solve_object()
/// @note Collective on comm.
double untuned_frequency(ObjectRequest request, int mode, MPI_Comm comm,
                         const std::filesystem::path& cache, core::Trace& trace);

/// How far above a band tuned modes are solved, for what their first estimate was off.
constexpr double tuning_margin = 1.02;

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
