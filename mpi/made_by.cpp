#include "mpi/made_by.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <fstream>

#include "core/revision.hpp"
#include "mpi/comm.hpp"

namespace carillon::mpi {

nlohmann::ordered_json made_by(const std::string& command, MPI_Comm world) {
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return {{"command", command},
          {"carillon", core::revision()},
          {"processor", processor_name()},
          {"ranks", size(world)},
          {"date", fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(now))}};
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos)
      return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace carillon::mpi
