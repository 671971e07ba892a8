#include "core/near_program.hpp"

#include <fmt/core.h>

namespace carillon::core {

namespace fs = std::filesystem;

fs::path find_near_program(std::initializer_list<std::string_view> places) {
  std::error_code error;
  const fs::path here = fs::read_symlink("/proc/self/exe", error).parent_path();
  if (error) return {};
  for (const std::string_view place : places) {
    const fs::path path = here / place;
    if (fs::is_regular_file(path, error)) return fs::weakly_canonical(path);
  }
  return {};
}

fs::path find_helper(std::string_view name) {
  return find_near_program(
      {fmt::format("../libexec/carillon/{}", name), name, fmt::format("../{}", name)});
}

}  // namespace carillon::core
