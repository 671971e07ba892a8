#pragma once

namespace carillon::cli {

/// For main(), before MPI starts: commands that need libtorch run in carillon-learn, which lies
/// beside this program and takes its place in the process. Returns where another command is asked
/// for, or there is no such program.
///
/// libtorch loads hundreds of libraries, which builds and everything else are to be spared.
void become_learner(char** argv);

}  // namespace carillon::cli
