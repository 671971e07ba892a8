#include "cli/build_options.hpp"

namespace carillon::cli {

dataset::run::BuildOptions with_common(dataset::run::BuildOptions options, const Context& context) {
  options.cache = context.cache;
  options.command = context.command;
  options.quiet = context.quiet || context.json;
  options.tell = options.tell_interrupted = teller(context);
  return options;
}

}  // namespace carillon::cli
