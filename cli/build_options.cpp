#include "cli/build_options.hpp"

#include <iostream>
#include <iterator>

#include "mpi/comm.hpp"
#include "mpi/exit_code.hpp"

namespace carillon::cli {

dataset::run::BuildOptions with_common(dataset::run::BuildOptions options, const Context& context) {
  options.cache = context.cache;
  options.command = context.command;
  options.tell = teller(context);
  options.tell_interrupted = [&context, tell = options.tell](
                                 const std::string& text, const nlohmann::ordered_json& document) {
    context.on_finish.note_exit(mpi::exit_interrupted);
    tell(text, document);
  };
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
