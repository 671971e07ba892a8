#include "core/near_program.hpp"

#include <dlfcn.h>
#include <fmt/core.h>

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

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

namespace {

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

/// The folders above the module that this code is part of, the nearest first; none for a program of
/// its own.
std::vector<fs::path> folders_above_module() {
  constexpr int depth = 6;  // PREFIX/lib/python3/dist-packages/carillon and two more
  Dl_info info{};
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): an address is asked about
  if (dladdr(reinterpret_cast<void*>(&find_near_program), &info) == 0) return {};
  fs::path path = fs::absolute(info.dli_fname);
  std::vector<fs::path> folders;
  if (path.extension() != ".so") return folders;
  for (int i = 0; i < depth && path.has_relative_path(); ++i) {
    path = path.parent_path();
    folders.push_back(path);
  }
  return folders;
}

fs::path find_above_module(std::initializer_list<std::string> places) {
  for (const fs::path& folder : folders_above_module()) {
    for (const std::string& place : places) {
      if (is_file(folder / place)) return fs::weakly_canonical(folder / place);
    }
  }
  return {};
}

/// Something that lies beside the `carillon` in PATH.
fs::path find_by_path(const std::string& place) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (is_file(fs::path(folder) / "carillon") && is_file(fs::path(folder) / place)) {
      return fs::weakly_canonical(fs::path(folder) / place);
    }
  }
  return {};
}

}  // namespace

fs::path find_helper(std::string_view name) {
  const std::string installed = fmt::format("libexec/carillon/{}", name);
  const std::string beside = "../" + installed;
  if (fs::path near = find_near_program({beside, name, fmt::format("../{}", name)}); !near.empty())
    return near;
  if (fs::path above = find_above_module({installed, std::string(name)}); !above.empty())
    return above;
  return find_by_path(beside);
}

fs::path find_carillon() {
  if (fs::path above = find_above_module({"bin/carillon", "carillon"}); !above.empty())
    return above;
  return find_by_path("carillon");
}

}  // namespace carillon::core
