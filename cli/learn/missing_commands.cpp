#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/evaluate/evaluation.hpp"
#include "cli/learn/commands.hpp"
#include "core/error.hpp"

namespace carillon::cli {

namespace {

[[noreturn]] void missing(const char* what) {
  throw core::InputError(
      fmt::format("{} needs carillon-learn, which does not lie beside this program", what),
      "build with libtorch: -DCARILLON_LEARN=ON");
}

RunEvaluation read_classification(core::ConfigNode&, core::ConfigNode&, const EvaluatedDatasets&) {
  missing("evaluate.classification");
}

constexpr EvaluationSection sections[] = {{"damping", read_damping_validation},
                                          {"classification", read_classification}};

}  // namespace

void add_missing_train(CLI::App& program, Context&) {
  CLI::App* command = program.add_subcommand("train", train_summary);
  command->allow_extras();
  command->callback([] { missing("train"); });
}

void add_plain_evaluate(CLI::App& program, Context& context) {
  add_evaluate(program, context, sections);
}

}  // namespace carillon::cli
