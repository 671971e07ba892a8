#include <CLI/CLI.hpp>

#include "cli/learn/commands.hpp"
#include "core/error.hpp"

namespace carillon::cli {

void add_missing_train(CLI::App& program, Context&) {
  CLI::App* command = program.add_subcommand("train", train_summary);
  command->allow_extras();
  command->callback([] {
    throw core::InputError("train needs carillon-learn, which does not lie beside this program",
                           "build with libtorch: -DCARILLON_LEARN=ON");
  });
}

}  // namespace carillon::cli
