#pragma once

#include <mpi.h>

#include <span>
#include <string>

namespace CLI {
class App;
}

namespace carillon::cli {

/// What every command gets: the world's ranks and the options before the command's name.
struct Context {
  MPI_Comm world = MPI_COMM_NULL;
  bool json = false;    ///< one JSON document on standard output instead of text
  bool quiet = false;   ///< no progress lines
  std::string cache;    ///< folder of meshes and modes; empty: none is kept
  std::string command;  ///< as it was typed, for files that say what made them
  int exit_code = 0;    ///< what the command ends with when it throws nothing

  /// Rank 0 speaks for all.
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
using AddCommand = void (*)(CLI::App& program, Context& context);
void add_accuracy(CLI::App& program, Context& context);
void add_build(CLI::App& program, Context& context);
void add_check(CLI::App& program, Context& context);
void add_compare(CLI::App& program, Context& context);
void add_completion(CLI::App& program, Context& context);
void add_estimate(CLI::App& program, Context& context);
void add_export(CLI::App& program, Context& context);
void add_export_faust(CLI::App& program, Context& context);
void add_export_gltf(CLI::App& program, Context& context);
void add_features(CLI::App& program, Context& context);
void add_fit(CLI::App& program, Context& context);
void add_inspect(CLI::App& program, Context& context);
void add_list(CLI::App& program, Context& context);
void add_texture(CLI::App& program, Context& context);
void add_manual(CLI::App& program, Context& context);
void add_modes(CLI::App& program, Context& context);
void add_plan(CLI::App& program, Context& context);
void add_preview(CLI::App& program, Context& context);
void add_realimpact(CLI::App& program, Context& context);
void add_report(CLI::App& program, Context& context);
void add_regenerate(CLI::App& program, Context& context);
void add_strike(CLI::App& program, Context& context);

/// Runs the program: parses, calls the command, turns errors into messages and exit codes.
/// @param more  commands beside those that every program has
int run(int argc, char** argv, MPI_Comm world, std::span<const AddCommand> more = {});

}  // namespace carillon::cli
