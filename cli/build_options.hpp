#pragma once

#include "cli/context.hpp"
#include "dataset/run/build.hpp"

namespace carillon::cli {

/// A build's options, with those that stand before the command's name.
dataset::run::BuildOptions with_common(dataset::run::BuildOptions options, const Context& context);

/// With the configuration that comes on standard input, where its file is called "-". Paths in it
/// are meant from the current folder.
/// @note Collective on the context's ranks.
dataset::run::BuildOptions with_standard_input(dataset::run::BuildOptions options,
                                               const Context& context);

}  // namespace carillon::cli
