#pragma once

#include "eval/features/feature_arguments.hpp"

namespace carillon::cli {

class Command;

/// Options of commands that analyse recordings.
void add_feature_arguments(Command& command, eval::features::FeatureArguments& arguments);

}  // namespace carillon::cli
