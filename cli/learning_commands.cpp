#include <fmt/format.h>

#include <memory>

#include "cli/command_line.hpp"
#include "cli/learn_program.hpp"
#include "cli/learning_commands.hpp"
#include "core/error.hpp"

namespace carillon::cli {

namespace {

[[noreturn]] void missing(const char* what) {
  throw core::InputError(
      fmt::format("{} needs carillon-learn, which is not installed", what),
      "build with libtorch (-DCARILLON_LEARN=ON), or install the package carillon-learn");
}

/// A command of a program without libtorch.
/// @param options  that its command line sets: they live as long as the command
void goes_elsewhere(Command& command, const char* name, const Context& context,
                    std::shared_ptr<const void> options) {
  command.begins_with(
      [&context, options = std::move(options)] { become_learner(context.arguments); });
  command.does([name] { missing(name); });
}

template <const char* name>
eval::studies::RunEvaluation read_missing(core::ConfigNode&, core::ConfigNode&,
                                          const eval::studies::EvaluatedDatasets&) {
  missing(name);
}

constexpr char classification[] = "classification", transfer[] = "transfer",
               spectrograms[] = "spectrograms";
constexpr eval::studies::EvaluationSection plain_sections[] = {
    {"damping", eval::studies::read_damping_validation},
    {classification, read_missing<classification>, true},
    {transfer, read_missing<transfer>, true},
    {spectrograms, read_missing<spectrograms>, true}};

void add_train(Program& program, Context& context, const LearningCommands& learning) {
  Command& command = program.add(
      "train", "classifiers that tell shapes and materials apart; goes on where it stopped",
      learning.train == nullptr ? Needs::nothing : Needs::solver);
  auto options = std::make_shared<TrainOptions>();
  command.option("config", options->build.config, "YAML configuration with a section `train`")
      .required();
  command.option("-o,--output", options->build.output,
                 "folder of the dataset and what is learnt (default: the configuration's name)");
  command
      .option("--set", options->build.overrides,
              "key=value instead of the configuration's, e.g. train.epochs=5")
      .one_value_each();
  add_device(command, options->device);
  command.flag("--search", options->search,
               "try the sizes of the section `search`, and tell which are best on the "
               "validation samples");
  command.footer(
      "Examples:\n"
      "  mpirun -n 2 carillon train configs/learning-smoke.yaml\n"
      "  mpirun -n 2 carillon train configs/learning-smoke.yaml --search\n"
      "  carillon train mine.yaml --set data=path/to/dataset --set train.seed=2\n"
      "Ranks share each step's samples; one thread a rank. docs/learning.md.");
  if (learning.train == nullptr) {
    goes_elsewhere(command, "train", context, options);
  } else {
    command.does([&context, options, run = learning.train] {
      options->build.overrides = with_device(options->build.overrides, options->device);
      context.exit_code = run(*options, context);
    });
  }
}

void add_identify(Program& program, Context& context, const LearningCommands& learning) {
  Command& command = program.add(
      "identify", "which shape and material a sound is of, and how sure that is", Needs::nothing);
  auto options = std::make_shared<IdentifyOptions>();
  command.option("clips", options->clips, "sounds of one strike each; of several the loudest")
      .required();
  command
      .option("-m,--models", options->models,
              "folder below which trained networks lie: the output of carillon train")
      .required();
  add_device(command, options->device);
  command.option("--method", options->method,
                 "networks of this name alone (default: the best on the validation samples)");
  command.option("--task", options->tasks, "answers to these tasks alone (default: all)");
  Option scene =
      command.option("--scene", options->scene, "configuration with motion to put the object into");
  Option at = command.option("--at", options->at, "x,y,z of the centre of its box [m]");
  scene.needs(at);
  at.needs(scene);
  command
      .option("-o,--output", options->output,
              "file for the longer scene (default: the scene's own)")
      .needs(scene);
  command.footer(
      "Examples:\n"
      "  carillon identify clip.wav --models carillon-learning-smoke\n"
      "  carillon identify *.wav -m carillon-rsaudio --task geometry material\n"
      "  carillon identify clip.wav -m out --scene scene.yaml --at 0.2,0,5cm -o with-it.yaml\n"
      "Only networks that hear and nothing else answer. docs/learning.md.");
  if (learning.identify == nullptr) {
    goes_elsewhere(command, "identify", context, options);
  } else {
    command.does([&context, options, run = learning.identify] { run(*options, context); });
  }
}

}  // namespace

void add_device(Command& command, std::string& device) {
  command
      .option("--device", device,
              "what networks are computed on: auto, cpu or cuda (default: train.device, else auto, "
              "a graphics card where there is one)")
      .one_of({"auto", "cpu", "cuda"});
}

std::vector<std::string> with_device(std::vector<std::string> overrides,
                                     const std::string& device) {
  if (!device.empty()) overrides.insert(overrides.begin(), "train.device=" + device);
  return overrides;
}

LearningCommands plain_commands() {
  return {.sections = plain_sections};
}

void add_learning_commands(Program& program, Context& context, const LearningCommands& learning) {
  add_train(program, context, learning);
  add_identify(program, context, learning);
  add_evaluate(program, context, learning.sections);
#ifdef CARILLON_SERVE
  add_serve(program, context);
  add_answer(program, context, learning.identifier);
#endif
}

}  // namespace carillon::cli
