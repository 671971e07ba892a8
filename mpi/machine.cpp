#include "mpi/machine.hpp"

#include <unistd.h>

#include <array>
#include <fstream>
#include <string>

namespace carillon::mpi {

Machine this_machine() {
  Machine machine;
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) == 0) machine.host = host.data();
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), machine.boot);
  machine.oom_kills = -1;
  std::ifstream counters("/proc/vmstat");
  std::string name;
  for (std::int64_t value = 0; counters >> name >> value;) {
    if (name == "oom_kill") machine.oom_kills = value;
  }
  return machine;
}

std::int64_t oom_kills_between(const Machine& before, const Machine& after) {
  const bool same = before.host == after.host && before.boot == after.boot && !before.boot.empty();
  if (!same || before.oom_kills < 0 || after.oom_kills < before.oom_kills) return -1;
  return after.oom_kills - before.oom_kills;
}

std::int64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::int64_t all = 0, resident = 0;
  if (!(file >> all >> resident)) return 0;
  return resident * sysconf(_SC_PAGESIZE);
}

}  // namespace carillon::mpi
