#include "cli/learn_program.hpp"

#include <unistd.h>

#include "core/near_program.hpp"

namespace carillon::cli {

void become_learner(char* const* arguments) {
  const auto program = core::find_helper("carillon-learn");
  if (!program.empty()) execv(program.c_str(), arguments);
}

}  // namespace carillon::cli
