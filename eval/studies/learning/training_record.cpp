#include "eval/studies/learning/training_record.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/json.hpp"

namespace carillon::eval::studies {

using nlohmann::json;
using nlohmann::ordered_json;

ordered_json to_json(const TrainingRecord& record) {
  ordered_json found = {{"key", record.key},
                        {"inputs", record.inputs},
                        {"source", record.source},
                        {"source_content", record.source_content},
                        {"source_folder", record.source_folder},
                        {"task", learning::to_json(record.task)},
                        {"method", learning::to_json(record.method)},
                        {"classes", record.classes},
                        {"samples",
                         {{"train", record.train_samples},
                          {"validation", record.validation_samples},
                          {"test", record.test_samples}}}};
  if (record.learnt) {
    const TrainingRecord::Learnt& learnt = *record.learnt;
    found["parameters"] = learnt.parameters;
    found["epochs"] = learnt.epochs;
    found["best_epoch"] = learnt.best_epoch;
    found["validation_loss"] = core::number_or_null(learnt.validation_loss);
    found["silent_samples"] = learnt.silent_samples;
    found["timing"] = {{"training_s", learnt.training_s}, {"waited_s", learnt.waited_s}};
  }
  if (record.recognition) found["recognition"] = recognition::to_json(*record.recognition);
  found["validation_accuracy"] = core::number_or_null(record.validation_accuracy);
  found["test_accuracy"] = core::number_or_null(record.test_accuracy);
  found["test_balanced_accuracy"] = core::number_or_null(record.test_balanced_accuracy);
  found["timing"]["seconds"] = record.seconds;
  found["ranks"] = record.ranks;
  found["device"] = record.device;
  found["remarks"] = record.remarks;
  return found;
}

TrainingRecord record_from(const json& found) {
  TrainingRecord record;
  record.key = found.at("key");
  record.inputs = found.at("inputs");
  record.source = found.at("source");
  record.source_content = found.at("source_content");
  record.source_folder = found.at("source_folder");
  record.task = learning::task_from(found.at("task"));
  record.method = learning::method_from(found.at("method"));
  record.classes = found.at("classes").get<std::vector<std::string>>();
  const json& samples = found.at("samples");
  record.train_samples = samples.at("train");
  record.validation_samples = samples.at("validation");
  record.test_samples = samples.at("test");
  const json& timing = found.at("timing");
  if (found.contains("parameters")) {
    record.learnt = {.parameters = found.at("parameters"),
                     .epochs = found.at("epochs"),
                     .best_epoch = found.at("best_epoch"),
                     .validation_loss = core::number_or_nan(found.at("validation_loss")),
                     .silent_samples = found.at("silent_samples"),
                     .training_s = timing.at("training_s"),
                     .waited_s = timing.at("waited_s")};
  }
  if (found.contains("recognition"))
    record.recognition = recognition::trial_from(found.at("recognition"));
  record.validation_accuracy = core::number_or_nan(found.at("validation_accuracy"));
  record.test_accuracy = core::number_or_nan(found.at("test_accuracy"));
  record.test_balanced_accuracy = core::number_or_nan(found.at("test_balanced_accuracy"));
  record.seconds = timing.at("seconds");
  record.ranks = found.at("ranks");
  record.device = found.value("device", record.device);
  record.remarks = found.at("remarks").get<std::vector<std::string>>();
  return record;
}

TrainingRecord read_record(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "training.json";
  const json found = core::read_json(path);
  if (found.is_null()) {
    throw core::InputError(fmt::format("{} is not there or damaged", path.string()),
                           "delete its folder, and it is trained again");
  }
  try {
    return record_from(found);
  } catch (const json::exception& error) {
    throw core::InputError(
        fmt::format("{} is of another version of the program: {}", path.string(), error.what()),
        "delete its folder, and it is trained again");
  }
}

}  // namespace carillon::eval::studies
