#include "core/near_program.hpp"

#include <fmt/core.h>

#include <cstdlib>
#include <sstream>
#include <string>

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
  const std::string installed = fmt::format("../libexec/carillon/{}", name);
  if (const fs::path near = find_near_program({installed, name, fmt::format("../{}", name)});
      !near.empty()) {
    return near;
  }
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path helper = fs::path(folder) / installed;
    std::error_code error;
    if (fs::is_regular_file(fs::path(folder) / "carillon", error) &&
        fs::is_regular_file(helper, error)) {
      return fs::weakly_canonical(helper);
    }
  }
  return {};
}

}  // namespace carillon::core
