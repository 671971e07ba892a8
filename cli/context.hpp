#pragma once

#include <mpi.h>

#include <string>

namespace carillon::cli {

class Program;
struct LearningCommands;

/// What every command gets: the world's ranks and the options before the command's name.
struct Context {
  MPI_Comm world = MPI_COMM_NULL;    ///< null for a command that needs no ranks and has none
  char* const* arguments = nullptr;  ///< of main(), null at the end
  bool json = false;                 ///< one JSON document on standard output instead of text
  bool quiet = false;                ///< no progress lines
  std::string cache;                 ///< folder of meshes and modes; empty: none is kept
  std::string command;               ///< as it was typed, for files that say what made them
  int exit_code = 0;                 ///< what the command ends with when it throws nothing

  /// Rank 0 speaks for all, also before MPI has started.
  bool speaks() const;
};

/// Exit codes of the program.
enum ExitCode {
  exit_done = 0,
  exit_internal = 1,
  exit_input = 2,     ///< usage, configuration, input, or a body that cannot be solved as asked
  exit_failures = 3,  ///< finished, but tasks failed or a pitch target was not met
  exit_interrupted = 130,
  exit_overdue = 152  ///< a task went on after its limit of time; as a shell tells SIGXCPU
};

/// Each adds one command to the program. A new command is one file, a line here and one in the list
/// `commands` of run.cpp.
using AddCommand = void (*)(Program& program, Context& context);
void add_accuracy(Program& program, Context& context);
void add_build(Program& program, Context& context);
void add_check(Program& program, Context& context);
void add_compare(Program& program, Context& context);
void add_completion(Program& program, Context& context);
void add_estimate(Program& program, Context& context);
void add_export(Program& program, Context& context);
void add_export_faust(Program& program, Context& context);
void add_export_gltf(Program& program, Context& context);
void add_features(Program& program, Context& context);
void add_fit(Program& program, Context& context);
void add_inspect(Program& program, Context& context);
void add_list(Program& program, Context& context);
void add_texture(Program& program, Context& context);
void add_manual(Program& program, Context& context);
void add_modes(Program& program, Context& context);
void add_plan(Program& program, Context& context);
void add_preview(Program& program, Context& context);
void add_realimpact(Program& program, Context& context);
void add_report(Program& program, Context& context);
void add_regenerate(Program& program, Context& context);
void add_strike(Program& program, Context& context);

/// Runs the program: parses, starts what the command needs and calls it, turns errors into messages
/// and exit codes. Call it first in main(); MPI, PETSc and SLEPc have ended when it returns.
/// @param learning  what a program with libtorch has in place of the commands that start one
int run(int argc, char** argv, const LearningCommands& learning);

}  // namespace carillon::cli
