#pragma once

#include "cli/context.hpp"
#include "dataset/run/build.hpp"

namespace carillon::cli {

/// A build's options, with those that stand before the command's name.
dataset::run::BuildOptions with_common(dataset::run::BuildOptions options, const Context& context);

}  // namespace carillon::cli
