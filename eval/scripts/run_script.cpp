#include "eval/scripts/run_script.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <vector>

#include "core/child_process.hpp"
#include "core/near_program.hpp"

namespace carillon::eval::scripts {

namespace {

namespace fs = std::filesystem;

/// The scripts exit with this where their module is missing.
constexpr int no_module = 4;

fs::path find_script(const std::string& name) {
  // Installed (carillon-learn in ../libexec/carillon), or in a build's folder or its tests'.
  return core::find_near_program({"../share/carillon/scripts/" + name,
                                  "../../share/carillon/scripts/" + name, "../scripts/" + name,
                                  "../../scripts/" + name});
}

/// Pythons to try: the one that is named, else the first of the path and the system's.
std::vector<fs::path> pythons() {
  if (const char* named = std::getenv("CARILLON_PYTHON"); named != nullptr && *named != '\0') {
    return {named};
  }
  std::vector<fs::path> found;
  std::string path = std::getenv("PATH") != nullptr ? std::getenv("PATH") : "";
  for (std::size_t from = 0; from <= path.size();) {
    const std::size_t end = std::min(path.find(':', from), path.size());
    const fs::path candidate = fs::path(path.substr(from, end - from)) / "python3";
    if (end > from && fs::exists(candidate)) {
      found.push_back(candidate);
      break;
    }
    from = end + 1;
  }
  if (const fs::path system = "/usr/bin/python3"; fs::exists(system)) found.push_back(system);
  return found;
}

}  // namespace

std::string run_script(const std::string& name, const std::vector<std::string>& arguments,
                       const std::string& module) {
  const fs::path script = find_script(name);
  if (script.empty()) return fmt::format("scripts/{} was not found", name);
  std::vector<std::string> words = {script.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::string reason = "there is no python3";
  for (const fs::path& python : pythons()) {
    const auto exit = core::run_child(python, words, /*seconds=*/300);
    if (exit.code == 0 && exit.signal == 0) return "";
    // Where the module is there and something else is wrong, the next Python would hide it.
    if (exit.code != no_module) {
      return fmt::format("{} failed: {}", script.string(), exit.output);
    }
    reason = fmt::format("{} has no {}; with one that has, run {}", python.string(), module,
                         fmt::join(words, " "));
  }
  return reason;
}

std::string draw_picture(const std::string& script, const fs::path& document) {
  const std::string reason = run_script(script, {document.string()}, "matplotlib");
  return reason.empty() ? "" : "no picture: " + reason;
}

}  // namespace carillon::eval::scripts
