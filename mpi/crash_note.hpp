#pragma once

#include <sys/types.h>

#include <string>

namespace carillon::mpi {

/// While one lives, a crash of this process (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, also by an
/// overflown stack of the thread that made it) writes the signal's name into a file before the
/// former handler, or the system, ends the process. The former handlers come back afterwards.
/// One at a time in a process.
class CrashNote {
 public:
  /// @param file    descriptor that is open for writing and outlives this object
  /// @param offset  where the name goes, up to 16 bytes and a newline
  CrashNote(int file, off_t offset);
  ~CrashNote();
  CrashNote(const CrashNote&) = delete;
  CrashNote& operator=(const CrashNote&) = delete;
};

}  // namespace carillon::mpi
