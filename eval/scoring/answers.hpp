#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/classification/confusion.hpp"
#include "eval/learning/task.hpp"

namespace carillon::eval::scoring {

/// What a classifier says of the samples of one part.
struct PartAnswers {
  std::vector<std::string> keys;       ///< of each sample
  std::vector<std::int32_t> labels;    ///< true class of each
  std::vector<std::uint32_t> objects;  ///< object of each: equal for one object in several sources
  std::vector<std::uint32_t> strikes;  ///< strike of each, likewise
  std::vector<float> scores;           ///< samples x classes: logits; of neighbours shares

  std::size_t samples() const { return keys.size(); }
};

/// `answers.h5` of a training.
struct Answers {
  std::vector<std::string> classes;
  PartAnswers validation, test;
};

/// What is known of the samples before a classifier is asked.
/// @param rows  of the part
PartAnswers asked(const learning::LabelledSamples& samples, const std::vector<std::uint32_t>& rows);

/// The true and the most likely class of each sample.
std::vector<std::size_t> true_classes(const PartAnswers& part);
std::vector<std::size_t> likely_classes(const PartAnswers& part, std::size_t classes);
/// Samples whose answers stand and fall together: those of an object where objects are held out
/// (`split_shape`), else those of a strike.
std::vector<std::size_t> groups_of(const PartAnswers& part, const std::string& split);
classification::Confusion confusion_of(const PartAnswers& part, std::size_t classes);

/// @throws StorageError
void write_answers(const std::filesystem::path& path, const Answers& answers);
/// @throws FileError  no such file, or not one of answers: an array is missing, or they do not fit
///                    together
Answers read_answers(const std::filesystem::path& path);

}  // namespace carillon::eval::scoring
