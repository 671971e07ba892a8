#pragma once

namespace carillon::cli {

/// Before MPI starts: carillon-learn (core::find_helper) takes its place in the
/// process and runs the same command line. Returns where there is no such program.
///
/// libtorch loads hundreds of libraries, which builds and everything else are to be spared.
/// @param arguments  of main(), null at the end
void become_learner(char* const* arguments);

}  // namespace carillon::cli
