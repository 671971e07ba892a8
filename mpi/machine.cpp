#include "mpi/machine.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "mpi/comm.hpp"
#include "mpi/detail/control_group.hpp"
#include "mpi/process_memory.hpp"

namespace carillon::mpi {

namespace {

constexpr std::int64_t unlimited = std::numeric_limits<std::int64_t>::max();

std::int64_t available() {
  std::ifstream file("/proc/meminfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("MemAvailable:")) continue;
    return std::stoll(line.substr(line.find(':') + 1)) * 1024;
  }
  return unlimited;
}

/// A number of an environment variable; 0 where it is not set.
std::int64_t number_of(const char* variable) {
  const char* text = std::getenv(variable);
  return text == nullptr ? 0 : std::strtoll(text, nullptr, 10);
}

/// [byte] that Slurm gave the job on this node. Slurm counts in MiB.
std::int64_t given_by_slurm() {
  constexpr std::int64_t mib = 1 << 20;
  if (const std::int64_t node = number_of("SLURM_MEM_PER_NODE"); node > 0) return node * mib;
  const std::int64_t each = number_of("SLURM_MEM_PER_CPU");
  const std::int64_t processors = number_of("SLURM_CPUS_ON_NODE");
  return each > 0 && processors > 0 ? each * processors * mib : unlimited;
}

}  // namespace

Machine describe_machine(MPI_Comm world, std::int64_t memory_per_node) {
  Comm node;
  MPI_Comm_split_type(world, MPI_COMM_TYPE_SHARED, rank(world), MPI_INFO_NULL, node.put());
  // A node is known by its first rank; its bounds are what that one sees.
  int first = rank(world);
  MPI_Bcast(&first, 1, MPI_INT, 0, node.get());
  std::int64_t held = process_memory().resident;
  MPI_Allreduce(MPI_IN_PLACE, &held, 1, MPI_INT64_T, MPI_SUM, node.get());
  std::int64_t memory = 0;
  bool measured = false;
  if (memory_per_node > 0) {
    memory = memory_per_node - held;
  } else {
    const std::int64_t given = given_by_slurm();
    const std::int64_t free = std::min(available(), memory_left_in_groups());
    memory = given == unlimited ? free : std::min(free, given - held);
    measured = memory == free;
  }
  std::ostringstream mine;
  mine << first << ' ' << std::max<std::int64_t>(memory, 0) << ' ' << measured;

  Machine machine;
  std::vector<int> first_of_node;
  for (const std::string& text : all_gather(mine.str(), world)) {
    std::istringstream in(text);
    in >> first >> memory >> measured;
    const auto found = std::find(first_of_node.begin(), first_of_node.end(), first);
    machine.node_of_rank.push_back(static_cast<int>(found - first_of_node.begin()));
    if (found != first_of_node.end()) continue;
    first_of_node.push_back(first);
    machine.memory.push_back(memory);
    machine.measured = machine.measured || measured;
  }
  return machine;
}

}  // namespace carillon::mpi
