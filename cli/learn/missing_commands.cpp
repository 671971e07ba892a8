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

void add_missing(CLI::App& program, const char* name, const char* summary, const char* footer) {
  CLI::App* command = program.add_subcommand(name, summary);
  command->footer(footer);
  command->allow_extras()->fallthrough(false);  // whatever is asked of it
  command->callback([name] { missing(name); });
}

template <const char* name>
RunEvaluation read_missing(core::ConfigNode&, core::ConfigNode&, const EvaluatedDatasets&) {
  missing(name);
}

constexpr char classification[] = "classification", transfer[] = "transfer",
               spectrograms[] = "spectrograms";
constexpr EvaluationSection sections[] = {{"damping", read_damping_validation},
                                          {classification, read_missing<classification>},
                                          {transfer, read_missing<transfer>},
                                          {spectrograms, read_missing<spectrograms>}};

}  // namespace

void add_missing_train(CLI::App& program, Context&) {
  add_missing(program, "train", train_summary, train_footer);
}

void add_missing_identify(CLI::App& program, Context&) {
  add_missing(program, "identify", identify_summary, identify_footer);
}

void add_plain_evaluate(CLI::App& program, Context& context) {
  add_evaluate(program, context, sections);
}

}  // namespace carillon::cli
