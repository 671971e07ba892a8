#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/audio.hpp"
#include "eval/recognition/recognition.hpp"

namespace carillon::eval::studies {

/// A trained network that answers for single sounds.
class Recogniser {
 public:
  /// @param folder  of the training: `model` and `recognition`
  /// @throws FileError, InputError  one is not there, or damaged
  explicit Recogniser(const std::filesystem::path& folder);

  const std::string& task() const { return task_; }
  const std::string& column() const { return column_; }
  /// Folder of the training, and of the dataset or recordings that it was trained with.
  const std::filesystem::path& folder() const { return folder_; }
  const std::filesystem::path& source() const { return source_; }
  const std::string& method() const { return learner_.method().name; }
  const std::vector<std::string>& classes() const { return learner_.classes(); }
  /// The first of a class's labels: the class itself where it has no others.
  std::string label_of(const std::string& name) const;
  /// Whether it met sounds of none of its classes while it learnt.
  bool knows_of_others() const { return learner_.method().learning.outliers > 0; }
  double threshold() const { return recognition_.threshold; }
  /// Of the validation samples; -1 where there were none.
  double validation_accuracy() const { return validation_accuracy_; }
  /// What its training measured on what was held out: `accuracy`, null without test samples,
  /// `samples` of the test, `calibrated` (whether there were validation samples) and `recognition`
  /// as training.json has it.
  const nlohmann::ordered_json& measured() const { return measured_; }

  /// @throws InputError  no samples, or one that is not finite
  recognition::Recognised operator()(const core::AudioClip& recording) const;

 private:
  Recogniser(const std::filesystem::path& folder, const nlohmann::ordered_json& record);

  std::filesystem::path folder_;
  std::string task_, column_;
  std::map<std::string, std::vector<std::string>> labels_;  ///< of classes that have several
  std::filesystem::path source_;
  networks::Learner learner_;
  recognition::Recognition recognition_;
  double validation_accuracy_;
  nlohmann::ordered_json measured_;
  learning::ClipPreparer preparer_;
};

/// The networks below a folder that only hear: of each task the one that was best on its validation
/// samples, among those that learnt the same as the newest.
/// @param method  of this name alone; "" for any
/// @param tasks   of these alone; none for all
/// @throws InputError  there is none, or of one task from several sources; says what to do
std::vector<Recogniser> find_recognisers(const std::filesystem::path& folder,
                                         const std::string& method,
                                         const std::vector<std::string>& tasks);

}  // namespace carillon::eval::studies
