#include "mpi/host.hpp"

#include <unistd.h>

#include <array>
#include <fstream>
#include <string>

namespace carillon::mpi {

Host this_host() {
  Host host;
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) == 0) host.name = name.data();
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), host.boot);
  host.oom_kills = -1;
  std::ifstream counters("/proc/vmstat");
  std::string counter;
  for (std::int64_t value = 0; counters >> counter >> value;) {
    if (counter == "oom_kill") host.oom_kills = value;
  }
  return host;
}

std::int64_t oom_kills_between(const Host& before, const Host& after) {
  const bool same = before.name == after.name && before.boot == after.boot && !before.boot.empty();
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
