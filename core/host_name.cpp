#include "core/host_name.hpp"

#include <unistd.h>

#include <array>

namespace carillon::core {

std::string host_name() {
  // POSIX has names of up to 255 characters, and leaves open whether one that is cut off is ended.
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

}  // namespace carillon::core
