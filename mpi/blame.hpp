#pragma once

#include <string>
#include <vector>

#include "mpi/witness.hpp"

namespace carillon::mpi {

/// What speaks against a task that ran when a run ended.
struct Blame {
  enum class Evidence {
    crash,    ///< its process caught a signal of its own making
    memory,   ///< its process was ended without a word, and its machine had run out of memory
    overdue,  ///< its process ended itself since the task took too long
    silence,  ///< its process, and no other one, ended without a word: it proves little
  } evidence = Evidence::silence;
  std::string process;  ///< of the testimony
  std::string task;
  std::string stage;
  std::string item;
  std::string words;  ///< for a person: what happened, e.g. "SIGSEGV"
};

/// Which tasks of a run that ended before its time are to blame for that; at most one entry for
/// each task.
///
/// Innocent is whoever was asked to stop (mpirun asks all ranks when it ends a job, so this clears
/// those that merely ran beside a crash), and whoever was silenced together with others on a
/// machine that had memory left: a killed mpirun, a batch system's last word or a power cut speak
/// against nobody. Where a machine ran out of memory, the silent process that held most of it is
/// blamed.
///
/// @param told  of one run
/// @param now   the hosts that can be asked whether they ran out of memory
std::vector<Blame> blamed_tasks(const std::vector<Testimony>& told, const std::vector<Host>& now);

/// "crash", "memory", "overdue" or "silence".
std::string name_of(Blame::Evidence evidence);

}  // namespace carillon::mpi
