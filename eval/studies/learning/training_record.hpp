#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/numbers.hpp"
#include "eval/recognition/recognition.hpp"

namespace carillon::eval::studies {

/// What is kept of a training that ended: training.json.
struct TrainingRecord {
  std::string key;                                    ///< for people: geometry/isnn-a/seed-1
  std::string inputs;                                 ///< hash of all that decides the result
  std::string source, source_content, source_folder;  ///< what it learnt from
  learning::TaskSpec task;
  learning::Method method;
  std::vector<std::string> classes;
  std::size_t train_samples = 0, validation_samples = 0, test_samples = 0;
  /// Of what learns numbers, as neighbours do not.
  struct Learnt {
    std::int64_t parameters = 0;
    std::size_t epochs = 0;
    std::int64_t best_epoch = 0;
    double validation_loss = core::nan;  ///< of that epoch; NaN without samples for it
    std::size_t silent_samples = 0;
    double training_s = 0, waited_s = 0;
  };
  std::optional<Learnt> learnt;
  std::optional<recognition::RecognitionTrial> recognition;  ///< of a network that only hears
  double validation_accuracy = core::nan;                    ///< NaN without samples for it
  double test_accuracy = core::nan, test_balanced_accuracy = core::nan;
  double seconds = 0;  ///< in all
  int ranks = 1;
  std::string device = "cpu";  ///< or cuda
  std::vector<std::string> remarks;
};

nlohmann::ordered_json to_json(const TrainingRecord& record);
/// @throws nlohmann::json::exception, InputError  it is of another version of the program
TrainingRecord record_from(const nlohmann::json& json);

/// The record in a training's folder.
/// @throws FileError, InputError  it is not there, damaged, or of another version of the program
TrainingRecord read_record(const std::filesystem::path& folder);

}  // namespace carillon::eval::studies
