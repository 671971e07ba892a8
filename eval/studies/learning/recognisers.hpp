#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/audio.hpp"
#include "eval/studies/learning/training_record.hpp"

namespace carillon::eval::studies {

/// A trained network that answers for single sounds.
class Recogniser {
 public:
  /// @param folder  of the training: `model` and `recognition`
  /// @throws FileError, InputError  one is not there, or damaged
  explicit Recogniser(const std::filesystem::path& folder,
                      learning::Device device = learning::Device::automatic);

  /// Folder of the training.
  const std::filesystem::path& folder() const { return folder_; }
  /// What it learnt from, and what was measured on what was held out.
  const TrainingRecord& record() const { return record_; }
  const std::string& task() const { return record_.task.name; }
  const std::string& method() const { return learner_.method().name; }
  const std::vector<std::string>& classes() const { return learner_.classes(); }
  /// The first of a class's labels: the class itself where it has no others.
  std::string label_of(const std::string& name) const;
  /// Whether it met sounds of none of its classes while it learnt.
  bool knows_of_others() const { return learner_.method().learning.outliers > 0; }
  double threshold() const { return recognition_.threshold; }

  /// @throws InputError  no samples, or one that is not finite
  recognition::Recognised operator()(const core::AudioClip& recording) const;

 private:
  std::filesystem::path folder_;
  TrainingRecord record_;
  networks::Learner learner_;
  recognition::Recognition recognition_;
  learning::ClipPreparer preparer_;
};

/// Accuracy on the validation samples; -1 where there were none.
double validation_rank(const TrainingRecord& record);

/// The networks below a folder that only hear: of each task the one that was best on its validation
/// samples, among those that learnt the same as the newest.
/// @param method  of this name alone; "" for any
/// @param tasks   of these alone; none for all
/// @throws InputError  there is none, or of one task from several sources; says what to do
std::vector<Recogniser> find_recognisers(const std::filesystem::path& folder,
                                         const std::string& method,
                                         const std::vector<std::string>& tasks,
                                         learning::Device device = learning::Device::automatic);

}  // namespace carillon::eval::studies
