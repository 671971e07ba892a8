#pragma once

#include <cstdint>

namespace carillon::mpi {

/// Memory of this process [byte]; 0 where it cannot be read.
struct ProcessMemory {
  std::int64_t resident = 0;  ///< that lies in RAM
  std::int64_t data = 0;      ///< data and stack, as RLIMIT_DATA counts them
};
/// Allocates nothing, so that it can be asked when there is nothing left.
ProcessMemory process_memory();

}  // namespace carillon::mpi
