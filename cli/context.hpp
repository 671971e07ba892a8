#pragma once

#include <mpi.h>

#include <functional>
#include <string>

#include "cli/on_finish.hpp"
#include "core/tell.hpp"
#include "mpi/exit_code.hpp"

namespace carillon::cli {

class Command;

/// What every command gets: the world's ranks and the options before the command's name.
struct Context {
  MPI_Comm world = MPI_COMM_NULL;    ///< null for a command that needs no ranks and has none
  char* const* arguments = nullptr;  ///< of main(), null at the end
  bool json = false;                 ///< one JSON document on standard output instead of text
  bool quiet = false;                ///< no progress lines
  bool verbose = false;              ///< each task, too
  std::string log;                   ///< file that gets all that is said; "": none
  std::string finish_command;        ///< of the shell, when the program has ended; "": none
  OnFinish on_finish{};
  std::string cache;                ///< folder of meshes and modes; empty: none is kept
  const Command* chosen = nullptr;  ///< that runs
  std::string command;              ///< as it was typed, for files that say what made them
  int exit_code = 0;                ///< what the command ends with when it throws nothing

  /// Rank 0 speaks for all, also before MPI has started.
  bool speaks() const;
};

/// Refuse an output that could not be written, before there is any work for it: -o names a file or
/// a folder. An empty name passes.
/// @throws FileError
/// @note Collective where the command has ranks: rank 0 looks.
void require_output_file(const Context& context, const std::string& path);
void require_output_folder(const Context& context, const std::string& path);

/// What one rank does for all, which end with its outcome.
/// @note Collective on context.world.
void on_one_rank(const Context& context, const std::function<void()>& action);

/// Says results on standard output, as the options ask for them.
core::Tell teller(const Context& context);

}  // namespace carillon::cli
