#include "cli/build_options.hpp"

#include <iostream>
#include <iterator>

#include "mpi/comm.hpp"

namespace carillon::cli {

dataset::run::BuildOptions with_common(dataset::run::BuildOptions options, const Context& context) {
  options.cache = context.cache;
  options.command = context.command;
  options.quiet = context.quiet || context.json;
  options.tell = options.tell_interrupted = teller(context);
  return options;
}

dataset::run::BuildOptions with_standard_input(dataset::run::BuildOptions options,
                                               const Context& context) {
  if (options.config != "-") return options;
  options.config = "stdin";
  std::string text;
  if (mpi::rank(context.world) == 0) {
    text.assign(std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>());
  }
  options.text = mpi::broadcast(text, 0, context.world);
  return options;
}

}  // namespace carillon::cli
