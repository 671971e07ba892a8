#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/numbers.hpp"
#include "eval/learning/clip.hpp"
#include "eval/networks/training.hpp"
#include "eval/statistics/summary.hpp"

namespace carillon::eval::recognition {

/// What a trained network needs to answer for a sound by itself: how its sounds are prepared, what
/// makes its confidences right, and how sure it is of sounds of its classes.
struct Recognition {
  learning::ClipFormat format;
  double temperature = 1;  ///< divides logits (Guo et al. 2017), from the validation samples
  double threshold = 0;    ///< log odds that `accepted_fraction` of the validation samples reach
};

/// Share of known sounds that are to be taken for known.
inline constexpr double accepted_fraction = 0.95;

/// Answer for one sound.
struct Recognised {
  std::vector<double> probabilities;  ///< of each class
  double log_odds = 0;                ///< of the likely class
  bool known = false;                 ///< it reaches the threshold, and is not silent
};

/// From a trained network and its validation samples' logits; without any the temperature is 1, and
/// the threshold is the training samples'.
/// @note Collective on the ranks.
Recognition learn_recognition(networks::Learner& learner, learning::SampleSource& source,
                              const learning::LabelledSamples& samples,
                              std::span<const float> validation,
                              const networks::LearningRanks& ranks);

/// Fraction of sounds that a network takes for none of its classes.
/// @param validation, asked  logits of its validation samples and of the sounds, rows x classes
/// @param truth  class of each validation sample
double unknown_fraction(std::span<const float> validation, std::span<const std::size_t> truth,
                        std::span<const float> asked, std::size_t classes);

/// @param preparer  of the recognition's format
/// @param clip      likewise
Recognised recognise(const networks::Learner& learner, const Recognition& recognition,
                     const learning::ClipPreparer& preparer, std::span<const float> clip);

/// How well that works on what was held out.
struct RecognitionTrial {
  double temperature = 1;  ///< of the recognition
  /// Expected calibration error of the test samples, with the temperature and without; NaN without
  /// test samples.
  double calibration_error = 0, uncalibrated_error = 0;
  /// What the error would be if the confidences were right, and groups stood and fell together.
  double calibration_by_chance = 0;
  double accepted = 0;  ///< fraction of test samples that are taken for known
  /// Of sounds of none of the classes: area under the receiver operating characteristic against the
  /// test samples, and the fraction that is taken for known.
  struct Unknown {
    std::size_t sounds = 0;
    double auroc = 0;
    core::Range
        auroc95;  ///< for other objects; of what is known for other strikes where they are held out
    double accepted = 0;
  };
  /// `left_out`: the source's samples of labels that the task leaves out, where there are; `white`,
  /// `pink`, `brown`, `hum` and `babble`: noises, the last of which is speech-like. Of those, brown
  /// and babble are never learnt from.
  std::map<std::string, Unknown> unknown = {};
};

/// @param test         logits of the test samples
/// @param test_groups  of each, whose answers stand and fall together
/// @note Collective on the ranks.
RecognitionTrial try_recognition(const Recognition& recognition, networks::Learner& learner,
                                 learning::SampleSource& source,
                                 const learning::LabelledSamples& samples,
                                 std::span<const float> test,
                                 std::span<const std::size_t> test_groups,
                                 const networks::LearningRanks& ranks);

nlohmann::ordered_json to_json(const RecognitionTrial& trial);
RecognitionTrial trial_from(const nlohmann::json& json);

/// @throws StorageError
void save_recognition(const std::filesystem::path& path, const Recognition& recognition);
/// @throws FileError, InputError  no such file, or damaged
Recognition load_recognition(const std::filesystem::path& path);

}  // namespace carillon::eval::recognition
