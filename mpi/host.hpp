#pragma once

#include <cstdint>
#include <string>

namespace carillon::mpi {

/// A machine as its kernel tells it, for one question: did it end a process for lack of memory?
struct Host {
  std::string name;
  std::string boot;            ///< changes whenever it starts anew; "" where it cannot be read
  std::int64_t oom_kills = 0;  ///< since then; -1 where it cannot be read

  bool operator==(const Host&) const = default;
};

/// The one this process runs on, now. Costs a fraction of a millisecond.
Host this_host();

/// How many processes the machine has ended for lack of memory between two looks at it; -1 where
/// that cannot be known (another machine, started anew in between, or a kernel that does not
/// count).
std::int64_t oom_kills_between(const Host& before, const Host& after);

/// Memory of this process that lies in RAM [byte]; 0 where it cannot be read.
std::int64_t resident_bytes();

}  // namespace carillon::mpi
