#pragma once

#include <string>
#include <utility>

#include "solvers/libraries/one_thread.hpp"

namespace carillon::solvers::libraries {

/// Starts PETSc and SLEPc after MPI and ends them before it; one object of a program, made on every
/// rank. Of PETSc's options those in rank 0's PETSC_OPTIONS are read, no command line and no file
/// of options that lies about; signal handlers stay as they are; PETSc's errors print nothing and
/// are collected for check(). CHOLMOD's own threads are switched off. A BLAS that is slow or has
/// threads of its own is warned of once, by rank 0.
/// @note Collective on MPI_COMM_WORLD.
class SolverEnvironment {
 public:
  SolverEnvironment();
  ~SolverEnvironment();
  SolverEnvironment(const SolverEnvironment&) = delete;
  SolverEnvironment& operator=(const SolverEnvironment&) = delete;

 private:
  OneThread one_thread_;
};

/// Turns a PETSc or SLEPc return code into an exception.
/// @throws core::SolverError  with the library's message when `code` is not 0; what guarded() kept
void check(int code);

/// Keeps the exception that is being handled for the next check(): none may cross PETSc's frames.
/// @return PETSc's code for an error, to be handed on
int keep_exception();

/// What a function does that PETSc calls, its exceptions kept for check().
template <class F>
int guarded(F&& function) {
  try {
    std::forward<F>(function)();
    return 0;
  } catch (...) {
    return keep_exception();
  }
}

/// PETSc's options at the start, alike on every rank, one blank between words: modes that were
/// found with other options are others. Without what only prints (monitors, views, logs).
const std::string& solver_options();

/// Options of the PETSc data base under one prefix that no other object has; removed at the end.
class ScopedOptions {
 public:
  ScopedOptions();
  ~ScopedOptions();
  ScopedOptions(const ScopedOptions&) = delete;
  ScopedOptions& operator=(const ScopedOptions&) = delete;

  /// "carillon_17_"; the same on every rank that has made as many.
  const std::string& prefix() const { return prefix_; }
  /// @param name  without dash and prefix, e.g. "mat_mumps_icntl_13"
  void set(const std::string& name, const std::string& value);

 private:
  std::string prefix_;
  std::string names_;
};

}  // namespace carillon::solvers::libraries
