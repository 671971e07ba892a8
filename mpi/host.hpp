#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace carillon::mpi {

/// A machine as its kernel tells it, for one question: did it end a process for lack of memory?
struct Host {
  std::string name;
  std::string boot;            ///< changes whenever it starts anew; "" where it cannot be read
  std::int64_t oom_kills = 0;  ///< since then; -1 where it cannot be read
  /// The job's or container's own group of processes on it, and its count (kills_in_group).
  std::string group{};
  std::int64_t group_oom_kills = -1;

  bool operator==(const Host&) const = default;
};

/// The one this process runs on, now. Costs a fraction of a millisecond.
Host this_host();

/// As an object of JSON, and back. Members of the group may be missing.
nlohmann::json to_json(const Host& host);
Host host_from_json(const nlohmann::json& json);

/// How many processes have been ended for lack of memory between two looks: in the group where both
/// are of the same one, as neighbours on a shared machine are no concern of a job's; else on the
/// whole machine. -1 where that cannot be known (another machine, started anew in between, or a
/// kernel that does not count).
std::int64_t oom_kills_between(const Host& before, const Host& after);

/// Memory of this process [byte]; 0 where it cannot be read.
struct ProcessMemory {
  std::int64_t resident = 0;  ///< that lies in RAM
  std::int64_t data = 0;      ///< data and stack, as RLIMIT_DATA counts them
};
/// Allocates nothing, so that it can be asked when there is nothing left.
ProcessMemory process_memory();

}  // namespace carillon::mpi
