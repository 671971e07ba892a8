#include "cli/learn/learn_program.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <string_view>

namespace carillon::cli {

namespace {

/// The last two speak of all commands.
constexpr std::array<std::string_view, 5> learning_commands = {"train", "evaluate", "identify",
                                                               "completion", "manual"};

/// The command's name: the first argument that is no option and no value of one.
std::string_view command_of(char** argv) {
  for (char** argument = argv + 1; *argument != nullptr; ++argument) {
    const std::string_view text = *argument;
    if (text == "--cache" && argument[1] != nullptr) ++argument;
    if (!text.starts_with("-")) return text;
  }
  return {};
}

}  // namespace

void become_learner(char** argv) {
  const std::string_view command = command_of(argv);
  if (std::find(learning_commands.begin(), learning_commands.end(), command) ==
      learning_commands.end()) {
    return;
  }
  std::error_code error;
  const auto program =
      std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "carillon-learn";
  if (error || !std::filesystem::exists(program, error)) return;
  execv(program.c_str(), argv);
}

}  // namespace carillon::cli
