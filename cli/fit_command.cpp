#include <fmt/format.h>

#include <iterator>
#include <memory>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/feature_options.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/trace.hpp"
#include "eval/damping/fit_inputs.hpp"
#include "eval/damping/fit_report.hpp"
#include "eval/damping/law_text.hpp"

namespace carillon::cli {

namespace {

using eval::damping::Estimator;

struct FitCommandOptions {
  std::vector<std::string> recordings;
  eval::features::FeatureArguments features;
  std::vector<std::string> tables;
  std::string model = "rayleigh";
  std::string estimator = "mixture";
  std::string history;
};

std::vector<Estimator> estimators_of(const std::string& word) {
  if (word == "all")
    return {std::begin(eval::damping::all_estimators), std::end(eval::damping::all_estimators)};
  try {
    return {eval::damping::estimator_named(word)};
  } catch (const core::InputError& error) {
    throw core::InputError(error.message(), error.hint() + " or all");
  }
}

std::vector<eval::damping::FitSource> read_sources(const FitCommandOptions& options) {
  const eval::features::FeatureOptions wanted = eval::features::feature_options(options.features);
  std::vector<eval::damping::FitSource> sources;
  for (const std::string& path : options.recordings) {
    sources.push_back(eval::damping::fit_source_of_recording(path, wanted));
  }
  for (const std::string& path : options.tables)
    sources.push_back(eval::damping::fit_source_of_table(path, wanted.rt60));
  return sources;
}

void run_fit(const FitCommandOptions& options, const Context& context) {
  const std::vector<eval::damping::NamedLaw> laws = eval::damping::damping_laws(options.model);
  const std::vector<Estimator> estimators = estimators_of(options.estimator);
  const double begin = core::monotonic_seconds();
  std::vector<eval::damping::FitSource> sources = read_sources(options);
  const double features_seconds = core::monotonic_seconds() - begin;
  eval::damping::FitReport report =
      eval::damping::fit_sources(std::move(sources), laws, estimators, !options.history.empty());
  report.features_seconds = features_seconds;
  if (!context.speaks()) return;
  const std::string reasons = eval::damping::useless_sources(report.sources);
  if (!reasons.empty()) fmt::print(stderr, "carillon: without features:{}\n", reasons);
  if (!options.history.empty()) {
    core::write_text_durably(options.history, eval::damping::history_table(report.fits));
  }
  if (context.json) {
    fmt::print("{}\n", eval::damping::to_json(report).dump(2));
  } else {
    eval::damping::print_report(report);
  }
}

}  // namespace

void add_fit(Program& program, Context& context) {
  Command& command = program.add(
      "fit", "a material's damping from its sounds or their features, whatever held the object",
      Needs::nothing);
  auto options = std::make_shared<FitCommandOptions>();
  command.option("recordings", options->recordings,
                 "audio files, one strike each, of objects of one material");
  command
      .option("--features", options->tables,
              "table of features: columns frequency_hz,decay_rate_per_s and, where known, "
              "decay_rate_error_per_s")
      .one_value_each();
  command
      .option("--model", options->model,
              "rayleigh, caughey (three terms), caughey:N, power, hybrid, or a formula of "
              "lambda, omega, f and alpha1, alpha2, ...; several with commas between them, or all: "
              "the one of the lowest AIC is chosen")
      .show_default();
  command
      .option("--estimator", options->estimator,
              "mixture (excess of two kinds, errors, outliers, what rooms hide), emg (excess "
              "damping and errors), emg_relative (errors in proportion to damping), "
              "least_squares (errors alone), lower_bound (excess alone) or all")
      .show_default();
  command.option("--history", options->history, "CSV file for every step of the optimisers");
  add_feature_arguments(command, options->features);
  command.footer(
      "Examples:\n"
      "  carillon fit mug-*.wav --rt60 0.4\n"
      "  carillon fit --features mug.csv\n"
      "  carillon fit --features mug.csv --features bowl.csv --model hybrid --estimator all\n"
      "  carillon fit --features mug.csv --model all --json > fit.json\n"
      "  carillon fit --features mug.csv --model \"alpha1 + alpha2*sqrt(f)\" --json\n"
      "docs/damping-fits.md says when which estimator fits.");
  command.does([&context, options] { run_fit(*options, context); });
}

}  // namespace carillon::cli
