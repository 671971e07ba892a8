#include "mpi/process_memory.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

namespace carillon::mpi {

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
