#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/learning/sample_source.hpp"

namespace carillon::eval::learning {

enum class Part : std::uint8_t { train, validation, test };

/// What is to be told from what, and which samples it is learnt from.
struct TaskSpec {
  std::string name;
  std::string column;  ///< of labels: shape, family, material
  std::string split;   ///< column that says train, validation or test
  /// Labels that count as one class; empty: each is a class of its own. With it, labels that stand
  /// nowhere in it are left out.
  std::map<std::string, std::vector<std::string>> classes{};
  /// Of columns, labels that are left out: nothing is learnt of them, and they are none of the
  /// classes.
  std::map<std::string, std::vector<std::string>> except{};

  bool operator==(const TaskSpec&) const = default;
};

nlohmann::json to_json(const TaskSpec& task);
TaskSpec task_from(const nlohmann::json& json);

/// In place of a class: a label that the task leaves out; no label.
inline constexpr std::int32_t left_out = -1, unlabelled = -2;

/// A task's samples. Nothing depends on the order in which labels occur.
struct LabelledSamples {
  std::vector<std::string> classes;  ///< in byte order
  std::vector<std::int32_t> label;   ///< of each sample: class, `left_out` or `unlabelled`
  std::vector<Part> part;            ///< of each sample
  std::vector<std::string> keys;     ///< of each sample
  /// Of each sample: equal for samples of one object, and of one strike, of whatever source.
  std::vector<std::uint32_t> object_groups, strike_groups;

  /// Samples of the task in a part, ascending.
  std::vector<std::uint32_t> rows(Part part) const;
};

/// @throws InputError  no such column, a part that is none of the three, a label of two classes;
///                     names the source
LabelledSamples label_samples(const SampleSource& source, const TaskSpec& task);

/// @throws InputError  less than two classes, no sample to learn from, a label to leave out that
///                     there is not; names the source and the remedy
void require_learnable(const LabelledSamples& samples, const SampleSource& source,
                       const TaskSpec& task);

/// Classes that nothing is learnt of, or that are not tested: sentences for people.
std::vector<std::string> remarks(const LabelledSamples& samples);

}  // namespace carillon::eval::learning
