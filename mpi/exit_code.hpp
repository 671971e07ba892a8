#pragma once

#include "core/failure.hpp"

namespace carillon::mpi {

/// Exit codes of the program.
enum ExitCode {
  exit_done = 0,
  exit_internal = 1,
  exit_input = 2,     ///< usage, configuration, input, or an object that cannot be solved as asked
  exit_failures = 3,  ///< finished, but tasks failed or a pitch target was not met
  exit_interrupted = 130,
  exit_overdue = 152  ///< a task went on after its limit of time; as a shell tells SIGXCPU
};

/// Of a program that an error ends.
inline ExitCode exit_code_of(const core::Failure& failure) {
  return failure.kind == "Error" ? exit_internal : exit_input;
}

}  // namespace carillon::mpi
