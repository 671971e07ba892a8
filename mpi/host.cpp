#include "mpi/host.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/host_name.hpp"
#include "mpi/control_group.hpp"

namespace carillon::mpi {

Host this_host() {
  Host host;
  host.name = core::host_name();
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), host.boot);
  host.oom_kills = -1;
  std::ifstream counters("/proc/vmstat");
  std::string counter;
  for (std::int64_t value = 0; counters >> counter >> value;) {
    if (counter == "oom_kill") host.oom_kills = value;
  }
  const GroupKills group = kills_in_group();
  host.group = group.group;
  host.group_oom_kills = group.kills;
  return host;
}

std::int64_t oom_kills_between(const Host& before, const Host& after) {
  const bool same = before.name == after.name && before.boot == after.boot && !before.boot.empty();
  if (same && !before.group.empty() && before.group == after.group) {
    return after.group_oom_kills - before.group_oom_kills;
  }
  if (!same || before.oom_kills < 0 || after.oom_kills < before.oom_kills) return -1;
  return after.oom_kills - before.oom_kills;
}

nlohmann::json to_json(const Host& host) {
  return {{"host", host.name},
          {"boot", host.boot},
          {"oom_kills", host.oom_kills},
          {"group", host.group},
          {"group_oom_kills", host.group_oom_kills}};
}

Host host_from_json(const nlohmann::json& json) {
  return {json.at("host"), json.at("boot"), json.at("oom_kills"), json.value("group", ""),
          json.value("group_oom_kills", std::int64_t{-1})};
}

ProcessMemory process_memory() {
  const int file = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (file < 0) return {};
  std::array<char, 256> text{};
  const ssize_t length = read(file, text.data(), text.size() - 1);
  close(file);
  // size resident shared text libraries data, in pages
  std::array<std::int64_t, 6> pages{};
  char* at = text.data();
  for (std::int64_t& number : pages) number = std::strtoll(at, &at, 10);
  if (length <= 0) return {};
  const std::int64_t page = sysconf(_SC_PAGESIZE);
  return {page * pages[1], page * pages[5]};
}

}  // namespace carillon::mpi
