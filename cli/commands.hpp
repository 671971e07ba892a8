#pragma once

#include "cli/context.hpp"

namespace carillon::cli {

class Program;
struct LearningCommands;

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
void add_play(Program& program, Context& context);
void add_preview(Program& program, Context& context);
void add_realimpact(Program& program, Context& context);
void add_report(Program& program, Context& context);
void add_regenerate(Program& program, Context& context);
void add_score(Program& program, Context& context);
void add_schema(Program& program, Context& context);
void add_status(Program& program, Context& context);
void add_strike(Program& program, Context& context);

/// What HDF5 and Mesa look at when they are first called; a user's own setting stays. File systems
/// of clusters refuse locks in ways of their own, and a file's own property, by which core/hdf5
/// goes without, does not reach the sources of a virtual dataset. Mesa has no worker threads then,
/// and no files in the user's cache folder that many ranks would write at once. Call it in main(),
/// before there are threads that read the environment.
void set_libraries_up();

/// Runs the program: parses, starts what the command needs and calls it, turns errors into messages
/// and exit codes. Call it first in main(); MPI, PETSc and SLEPc have ended when it returns.
/// @param learning  what a program with libtorch has in place of the commands that start one
int run(int argc, char** argv, const LearningCommands& learning);

}  // namespace carillon::cli
