#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "cli/learning_commands.hpp"
#include "cli/option_values.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "core/trace.hpp"
#include "eval/studies/learning/recognised_scene.hpp"
#include "eval/studies/learning/recognisers.hpp"

namespace carillon::cli {

namespace {

using nlohmann::ordered_json;

/// What one network says of one clip.
struct Answer {
  const eval::studies::Recogniser* recogniser = nullptr;
  eval::recognition::Recognised recognised;
  std::vector<std::size_t> order;  ///< classes, the most likely first

  const std::string& best() const { return recogniser->classes()[order.front()]; }
};

Answer ask(const eval::studies::Recogniser& recogniser, const core::AudioClip& clip) {
  Answer answer{&recogniser, recogniser(clip), {}};
  const std::vector<double>& probabilities = answer.recognised.probabilities;
  answer.order.resize(probabilities.size());
  std::iota(answer.order.begin(), answer.order.end(), std::size_t{0});
  std::stable_sort(answer.order.begin(), answer.order.end(), [&](std::size_t a, std::size_t b) {
    return probabilities[a] > probabilities[b];
  });
  return answer;
}

/// The clip's answers by every network.
std::vector<Answer> ask_all(const std::vector<eval::studies::Recogniser>& recognisers,
                            const std::string& file) {
  const core::AudioClip clip = core::read_audio(file);
  std::vector<Answer> answers;
  try {
    for (const eval::studies::Recogniser& recogniser : recognisers)
      answers.push_back(ask(recogniser, clip));
  } catch (const core::InputError& error) {
    throw core::InputError(fmt::format("{}: {}", file, error.message()), error.hint());
  }
  return answers;
}

/// What a training measured on what was held out.
ordered_json measured(const eval::studies::TrainingRecord& record) {
  return {{"accuracy", core::number_or_null(record.test_accuracy)},
          {"samples", record.test_samples},
          {"calibrated", record.validation_samples > 0},
          {"recognition", record.recognition ? to_json(*record.recognition) : ordered_json()}};
}

ordered_json to_json(const Answer& answer) {
  const eval::recognition::Recognised& recognised = answer.recognised;
  ordered_json classes = ordered_json::object();
  for (const std::size_t c : answer.order) {
    classes[answer.recogniser->classes()[c]] = recognised.probabilities[c];
  }
  return {{"known", recognised.known},
          {"class", answer.best()},
          {"confidence", recognised.probabilities[answer.order.front()]},
          {"min_confidence", 1 / (1 + std::exp(-answer.recogniser->threshold()))},
          {"knows_of_others", answer.recogniser->knows_of_others()},
          {"measured", measured(answer.recogniser->record())},
          {"classes", classes},
          {"method", answer.recogniser->method()},
          {"model", answer.recogniser->folder().string()}};
}

/// As wide as the longest task's name, for columns that stand below one another.
std::size_t task_width(const std::vector<eval::studies::Recogniser>& recognisers) {
  std::size_t width = 0;
  for (const eval::studies::Recogniser& recogniser : recognisers) {
    width = std::max(width, recogniser.task().size());
  }
  return width;
}

void print(const std::string& file, const std::vector<Answer>& answers, std::size_t width) {
  fmt::print("{}\n", file);
  for (const Answer& answer : answers) {
    std::vector<std::string> likely;
    for (std::size_t i = 0; i < std::min<std::size_t>(3, answer.order.size()); ++i) {
      const std::size_t c = answer.order[i];
      likely.push_back(fmt::format("{} {:.1f} %", answer.recogniser->classes()[c],
                                   100 * answer.recognised.probabilities[c]));
    }
    if (!answer.recogniser->knows_of_others()) {
      likely.back() += " (trained with `outliers: 0`, so that sounds of none of these may pass)";
    }
    const std::string text = fmt::format("{}", fmt::join(likely, ", "));
    fmt::print("  {:{}}  {}\n", answer.recogniser->task(), width,
               answer.recognised.known ? text
                                       : fmt::format("none of these (else {}): unlike what it was "
                                                     "trained with",
                                                     text));
  }
}

/// How far each network may be trusted: what its training measured on what was held out.
void print_trust(const std::vector<eval::studies::Recogniser>& recognisers, std::size_t width) {
  fmt::print("\nOn what was held out in training:\n");
  for (const eval::studies::Recogniser& recogniser : recognisers) {
    const eval::studies::TrainingRecord& record = recogniser.record();
    std::vector<std::string> words = {recogniser.method()};
    if (record.recognition && !std::isnan(record.test_accuracy)) {
      const eval::recognition::RecognitionTrial& trial = *record.recognition;
      words.push_back(fmt::format("{:.1f} % of {} sounds right", 100 * record.test_accuracy,
                                  record.test_samples));
      words.push_back(fmt::format("confidences {:.1f} % off (by chance {:.1f} %)",
                                  100 * trial.calibration_error,
                                  100 * trial.calibration_by_chance));
      std::vector<std::string> areas;
      for (const auto& [name, unknown] : trial.unknown) {
        areas.push_back(fmt::format("{} {:.2f}", name, unknown.auroc));
      }
      words.push_back(fmt::format("told from others (AUROC): {}", fmt::join(areas, ", ")));
    }
    if (record.validation_samples == 0) {
      words.push_back("confidences are not calibrated, as nothing was there to validate with");
    }
    fmt::print("  {:{}}  {}\n", recogniser.task(), width, fmt::join(words, "; "));
  }
}

/// Of a column's tasks the one that knows most classes, of equals the surer one: a network that
/// learnt fewer takes others' sounds for its own. Null without such a task.
const Answer* fullest_answer(const std::vector<Answer>& answers, const std::string& column) {
  const Answer* fullest = nullptr;
  const auto rank = [](const Answer& answer) {
    return std::pair(answer.recogniser->classes().size(),
                     eval::studies::validation_rank(answer.recogniser->record()));
  };
  for (const Answer& answer : answers) {
    if (answer.recogniser->record().task.column != column) continue;
    if (fullest == nullptr || rank(answer) > rank(*fullest)) fullest = &answer;
  }
  return fullest;
}

/// The first known answer to one of these columns.
const Answer& answer_of(const std::vector<Answer>& answers, const std::vector<std::string>& columns,
                        const std::string& what) {
  const Answer* unknown = nullptr;
  for (const std::string& column : columns) {
    const Answer* answer = fullest_answer(answers, column);
    if (answer == nullptr) continue;
    if (answer->recognised.known) return *answer;
    if (unknown == nullptr) unknown = answer;
  }
  if (unknown != nullptr) {
    throw core::InputError(fmt::format("the {} is none of those that {} was trained with", what,
                                       unknown->recogniser->method()),
                           "nothing is put into the scene");
  }
  throw core::InputError(
      fmt::format("no network tells the {}", what),
      fmt::format("train a task whose column is {}", fmt::join(columns, " or ")));
}

/// The scene with what was recognised in it.
std::string extended_scene(const IdentifyOptions& options, const Vec3& place,
                           const std::vector<Answer>& answers) {
  const Answer& shape = answer_of(answers, {"shape", "family"}, "shape");
  const Answer& material = answer_of(answers, {"material"}, "material");
  const eval::studies::TrainingRecord& record = shape.recogniser->record();
  eval::studies::RecognisedObject object = eval::studies::object_of_class(
      record.source_folder, record.task.column, shape.recogniser->label_of(shape.best()));
  object.material = eval::studies::material_of_class(
      material.recogniser->record().source_folder, material.recogniser->label_of(material.best()));
  return eval::studies::with_object(core::read_file(options.scene), options.scene, object, place);
}

/// The clip's answers by task.
ordered_json tasks_json(const std::vector<Answer>& answers) {
  ordered_json tasks = ordered_json::object();
  for (const Answer& answer : answers) tasks[answer.recogniser->task()] = to_json(answer);
  return tasks;
}

std::vector<eval::studies::Recogniser> load(const std::string& models, const std::string& method,
                                            const std::vector<std::string>& tasks,
                                            const std::string& device) {
  return eval::studies::find_recognisers(
      models, method, tasks, eval::learning::device_named(device.empty() ? "auto" : device));
}

}  // namespace

report::service::Identify make_identifier(const std::string& models, const std::string& device) {
  auto recognisers =
      std::make_shared<const std::vector<eval::studies::Recogniser>>(load(models, "", {}, device));
  return [recognisers](const std::filesystem::path& clip) {
    return ordered_json{{"tasks", tasks_json(ask_all(*recognisers, clip.string()))}};
  };
}

void run_identify(const IdentifyOptions& options, const Context& context) {
  if (!options.scene.empty() && options.clips.size() > 1) {
    throw core::InputError("--scene takes the object of one clip", "give one");
  }
  if (!context.speaks()) return;
  const double start = core::monotonic_seconds();
  const Vec3 place =
      options.scene.empty() ? Vec3::Zero().eval() : parse_position(options.at, "--at");
  const std::vector<eval::studies::Recogniser> recognisers =
      load(options.models, options.method, options.tasks, options.device);
  const std::size_t width = task_width(recognisers);
  ordered_json clips = ordered_json::array();
  std::vector<Answer> answers;
  for (const std::string& file : options.clips) {
    answers = ask_all(recognisers, file);
    clips.push_back({{"file", file}, {"tasks", tasks_json(answers)}});
    if (!context.json) print(file, answers, width);
  }
  if (!options.scene.empty()) {
    const std::string output = options.output.empty() ? options.scene : options.output;
    core::write_text_durably(output, extended_scene(options, place, answers));
    if (!context.json) fmt::print("{}: one object more\n", output);
  }
  if (!context.json) {
    print_trust(recognisers, width);
  } else {
    fmt::print("{}\n", ordered_json{{"clips", clips},
                                    {"timing", {{"identify_s", core::monotonic_seconds() - start}}}}
                           .dump(1));
  }
}

}  // namespace carillon::cli
