#include "cli/learn/commands.hpp"
#include "cli/learn/sections.hpp"

namespace carillon::cli {

namespace {

constexpr EvaluationSection sections[] = {{"damping", read_damping_validation},
                                          {"classification", read_classification},
                                          {"transfer", read_transfer_section},
                                          {"spectrograms", read_spectrograms}};

}  // namespace

void add_full_evaluate(CLI::App& program, Context& context) {
  add_evaluate(program, context, sections);
}

}  // namespace carillon::cli
