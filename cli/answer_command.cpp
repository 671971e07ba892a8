#include <unistd.h>

#include <memory>

#include "cli/command_line.hpp"
#include "cli/learn_program.hpp"
#include "cli/learning_commands.hpp"
#include "cli/object_options.hpp"
#include "cli/option_values.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "mpi/comm.hpp"
#include "mpi/made_by.hpp"
#include "scene/single_strike.hpp"
#include "solvers/families/families.hpp"

namespace carillon::cli {

namespace {

struct AnswerCommandOptions {
  report::service::AnswerOptions answers;
  std::string models, device;
};

/// A generated shape that is solved and struck, as `carillon strike` does it.
report::service::StruckInScene strike_shape(const std::string& shape,
                                            report::service::Options& given,
                                            const scene::SingleStrike& strike, double longest_clip,
                                            const Context& context) {
  const std::string family = shape.substr(0, shape.find(':'));
  solvers::families::find_family(family);
  if (family == "turned") {
    throw core::InputError("turned shapes come from files, and requests name none",
                           "take another shape: carillon list shapes");
  }
  ObjectOptions object;
  object.mesh = shape;
  object.material = given.text("material", "");
  object.tune = given.text("tune", "");
  object.max_modes = static_cast<int>(given.count("max_modes", object.max_modes, 1, 2000));
  std::vector<std::string> keys;
  // Values are read here: the keys' own text would be any YAML.
  const auto put = [&](const char* key, core::Dimension dimension, const char* usual) {
    const double value = core::parse_quantity(given.text(key, usual), dimension);
    keys.push_back(fmt::format("strikes.{}={}", key, value));
  };
  put("impulse", core::Dimension::impulse, scene::default_impulse);
  put("contact_time", core::Dimension::time, scene::default_contact_time);
  keys.push_back(fmt::format("audio.seconds={}", given.number("seconds", 1, 0.01, longest_clip)));
  const double sample_rate = given.number("sample_rate", 44100, 1000, 192000);
  keys.push_back(fmt::format("audio.sample_rate={}", sample_rate));
  keys.push_back(fmt::format("audio.gain={}", given.number("gain", 1, 0, 1e9)));
  object.max_frequency = fmt::format("{} Hz", std::min(20000.0, sample_rate / 2));
  if (const std::string listener = given.text("listener", ""); !listener.empty()) {
    const Vec3 ear = parse_position(listener, "listener");
    keys.push_back(
        fmt::format("listeners=[{{position: [{}, {}, {}]}}]", ear.x(), ear.y(), ear.z()));
  }
  given.finish();
  scene::Scene scene = scene::read_strike_scene(
      "{}", "strike", keys, scene::listed(region_materials(object)), "material");
  const scene::SolvedObject solved = solve_object(object, context, strike.known.position);
  return {scene::strike_once(scene, shape, solved, strike, context.cache), std::move(scene)};
}

void answer(const AnswerCommandOptions& options, Context& context, IdentifierMaker identifier) {
  if (mpi::size(context.world) > 1) {
    throw core::InputError("answer is one process, and mpirun started several",
                           "start it without mpirun");
  }
  report::service::AnswerOptions own = options.answers;
  own.made = mpi::made_by(context.command, context.world);
  own.strike_shape = [&context, longest = own.longest_clip](const std::string& shape,
                                                            report::service::Options& given,
                                                            const scene::SingleStrike& strike) {
    return strike_shape(shape, given, strike, longest, context);
  };
  if (!options.models.empty()) {
    if (identifier == nullptr) {
      throw core::InputError("--models needs carillon-learn, which is not installed",
                             "build with libtorch (-DCARILLON_LEARN=ON)");
    }
    own.identify = identifier(options.models, options.device);
  }
  // What libraries print goes where errors go: answers have the stream to themselves.
  const int output = ::dup(STDOUT_FILENO);
  if (output < 0 || ::dup2(STDERR_FILENO, STDOUT_FILENO) < 0) {
    throw core::FileError("standard output cannot be written to");
  }
  report::service::Answers answers(std::move(own));
  report::service::answer_requests(answers, STDIN_FILENO, output);
}

}  // namespace

void add_answer(Program& program, Context& context, IdentifierMaker identifier) {
  Command& command =
      program.add("answer",
                  "answers for sounds on standard input and output, as serve's own processes give "
                  "them",
                  Needs::solver);
  auto options = std::make_shared<AnswerCommandOptions>();
  command.option("folders", options->answers.folders, "folders whose objects may be struck");
  command.option("-m,--models", options->models, "folder below which trained networks lie")
      .show_default("none");
  add_device(command, options->device);
  command.option("--longest-clip", options->answers.longest_clip, "of a sound [s]")
      .range(0.01, 3600.0)
      .show_default();
  command.footer(
      "A request is a line of JSON and the bytes that it announces:\n"
      "  {\"path\": \"/v1/features\", \"query\": {\"max_features\": \"20\"}, \"parts\": [[\"\", "
      "88244]]}\n"
      "and so is its answer: {\"status\", \"type\", \"bytes\"}. docs/service.md\n"
      "\n"
      "Examples:\n"
      "  carillon answer < requests > answers\n"
      "  carillon answer carillon-smoke --models carillon-learning-smoke < requests > answers");
  if (identifier == nullptr) {
    command.begins_with([&context, options] {
      if (!options->models.empty()) become_learner(context.arguments);
    });
  }
  command.does([&context, options, identifier] { answer(*options, context, identifier); });
}

}  // namespace carillon::cli
