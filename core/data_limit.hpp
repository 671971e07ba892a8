#pragma once

#include <cstdint>

namespace carillon::core {

/// While one lives, allocations that would take the data of this process beyond so many bytes fail,
/// in all of its threads (a soft RLIMIT_DATA). One at a time in a process.
class DataLimit {
 public:
  /// @param bytes  0 or less: no limit; nor is there one under AddressSanitizer
  /// @throws Error  another one lives
  explicit DataLimit(std::int64_t bytes);
  ~DataLimit();
  DataLimit(const DataLimit&) = delete;
  DataLimit& operator=(const DataLimit&) = delete;

 private:
  bool set_ = false;
};

/// While any lives, the DataLimit of the process rests: for a thread that must not fail because
/// another one works under a limit. Costs a lock where there is none.
class DataLimitRests {
 public:
  DataLimitRests();
  ~DataLimitRests();
  DataLimitRests(const DataLimitRests&) = delete;
  DataLimitRests& operator=(const DataLimitRests&) = delete;
};

}  // namespace carillon::core
