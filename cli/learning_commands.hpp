#pragma once

#include <span>
#include <string>
#include <vector>

#include "cli/context.hpp"
#include "dataset/run/build.hpp"
#include "eval/studies/evaluation.hpp"
#include "report/service/answers.hpp"

namespace carillon::cli {

class Command;
class Program;

/// What `train` takes on the command line.
struct TrainOptions {
  dataset::run::BuildOptions build;
  std::string device;   ///< "" for the configuration's
  bool search = false;  ///< try sizes of networks instead
};

/// What `identify` takes on the command line.
struct IdentifyOptions {
  std::vector<std::string> clips;
  std::string models, method;
  std::vector<std::string> tasks;
  std::string scene, at, output;
  std::string device;  ///< "" for auto
};

/// Loads the networks below a folder, once.
/// @param device  "" for auto
/// @throws InputError  there are none
using IdentifierMaker = report::service::Identify (*)(const std::string& models,
                                                      const std::string& device);

/// What the commands that need libtorch do. Every program has the commands and their options; one
/// without libtorch lets carillon-learn take its place when they run, and where there is none says
/// so.
struct LearningCommands {
  /// @return the exit code, the same on every rank
  int (*train)(const TrainOptions& options, const Context& context) = nullptr;
  void (*identify)(const IdentifyOptions& options, const Context& context) = nullptr;
  IdentifierMaker identifier = nullptr;  ///< for `answer`
  /// Sections of `evaluate`; outlive the program's run.
  std::span<const eval::studies::EvaluationSection> sections{};
};

/// Without libtorch.
LearningCommands plain_commands();

/// In carillon-learn.
int run_train(const TrainOptions& options, const Context& context);
void run_identify(const IdentifyOptions& options, const Context& context);
report::service::Identify make_identifier(const std::string& models, const std::string& device);

/// The option --device.
/// @param device  is set by the command line, and outlives the program
void add_device(Command& command, std::string& device);
/// Overrides of a configuration in which a device that was asked for stands; --set comes after it.
std::vector<std::string> with_device(std::vector<std::string> overrides, const std::string& device);

/// `evaluate` with all sections that a program has.
/// @param sections  outlive the program's run
void add_evaluate(Program& program, Context& context,
                  std::span<const eval::studies::EvaluationSection> sections);

void add_serve(Program& program, Context& context);
/// `answer`, with networks where the program has them.
void add_answer(Program& program, Context& context, IdentifierMaker identifier);

/// Adds `train`, `identify`, `evaluate`, `serve` and `answer`.
void add_learning_commands(Program& program, Context& context, const LearningCommands& learning);

}  // namespace carillon::cli
