#pragma once

#include "cli/context.hpp"

namespace carillon::cli {

inline constexpr const char* train_summary =
    "classifiers that tell shapes and materials apart; goes on where it stopped";

inline constexpr const char* identify_summary =
    "which shape and material a sound is of, and how sure that is";

/// Commands of carillon-learn.
void add_train(CLI::App& program, Context& context);
void add_identify(CLI::App& program, Context& context);
/// With every section.
void add_full_evaluate(CLI::App& program, Context& context);

/// In their place where there is no carillon-learn: they are listed, and say what is missing.
void add_missing_train(CLI::App& program, Context& context);
void add_missing_identify(CLI::App& program, Context& context);
/// Without the sections that need libtorch.
void add_plain_evaluate(CLI::App& program, Context& context);

}  // namespace carillon::cli
