#pragma once

#include "cli/context.hpp"

namespace carillon::cli {

inline constexpr const char* train_summary =
    "classifiers that tell shapes and materials apart; goes on where it stopped";

inline constexpr const char* train_footer =
    "Examples:\n"
    "  mpirun -n 2 carillon train configs/learning-smoke.yaml\n"
    "  mpirun -n 2 carillon train configs/learning-smoke.yaml --search\n"
    "  carillon train mine.yaml --set data=path/to/dataset --set train.seed=2\n"
    "Ranks share each step's samples; one thread a rank. docs/learning.md.";

inline constexpr const char* identify_summary =
    "which shape and material a sound is of, and how sure that is";

inline constexpr const char* identify_footer =
    "Examples:\n"
    "  carillon identify clip.wav --models carillon-learning-smoke\n"
    "  carillon identify *.wav -m carillon-rsaudio --task geometry material\n"
    "  carillon identify clip.wav -m out --scene scene.yaml --at 0.2,0,5cm -o with-it.yaml\n"
    "Only networks that hear and nothing else answer. docs/learning.md.";

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
