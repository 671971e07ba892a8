#pragma once

#include <optional>
#include <string>
#include <vector>

#include "eval/classification/confusion_chance.hpp"
#include "eval/scoring/seed_answers.hpp"
#include "eval/studies/datasets.hpp"
#include "eval/studies/learning/detail/heard_difference.hpp"
#include "eval/studies/learning/learning_config.hpp"

namespace carillon::eval::studies {

/// What `evaluate.transfer` asks for: classifiers that learn in one condition and are tested in
/// another, recorded or held out.
struct TransferSpec {
  LearningConfig learning;
  learning::TaskSpec task;
  std::vector<learning::Method> methods;
  std::vector<std::uint64_t> seeds;  ///< every classifier is trained once with each
  Condition target;
  std::optional<std::size_t> own_target;  ///< of the datasets, where it is one of them
  std::vector<std::size_t> trained_on;    ///< of the datasets
  /// Training sets of one size, these fractions of which are the target's own (Sterling 2019,
  /// Fig. 6.8), the rest of the dataset; and the shares alone.
  std::optional<std::size_t> mixed_with;  ///< of the datasets
  std::vector<double> fractions;
  std::size_t against = 0;  ///< of the datasets, the one that others' gains are over
  std::size_t heard = 0;    ///< sounds of a dataset that are compared with the target's by ear
};

/// @throws ConfigError
TransferSpec read_transfer(core::ConfigNode& node, core::ConfigNode& root,
                           const EvaluatedDatasets& datasets);

/// What was learnt from.
enum class LearntFrom {
  elsewhere,  ///< another dataset
  target,     ///< the target's own samples
  mixed,      ///< a fraction of them, and others
  alone       ///< the fraction without others
};

/// How the classifiers of one method did that learnt from the same samples.
struct TransferRow {
  LearntFrom kind = LearntFrom::elsewhere;
  std::string trained_on;  ///< name of the dataset; "mixed" and "target alone" of mixes
  std::string method;
  double fraction = 0;                              ///< of the target's own samples in training
  std::size_t samples = 0;                          ///< for training
  std::optional<scoring::Estimate> own;             ///< accuracy where it learnt, if elsewhere
  std::optional<scoring::Estimate> there;           ///< accuracy in the target condition
  std::optional<scoring::Estimate> balanced_there;  ///< mean of the classes' recalls there
  /// Fraction of the target's sounds that networks which only hear take for none of their classes.
  std::optional<double> unknown_there;
  std::vector<std::string> classes;           ///< of the answers
  classification::Confusion confusion_there;  ///< of all seeds together
  std::optional<scoring::Estimate>
      less_home;                          ///< by how much that is above what the target's own teach
  std::optional<scoring::Estimate> gain;  ///< and above what the dataset `against` teaches
  /// Frobenius norm of the difference of their confusions in both (Sterling 2019, Fig. 4.13), of
  /// fractions of all seeds' answers; what chance alone makes of it; how many classes were
  /// compared.
  std::optional<double> confusion_norm;
  classification::NormByChance norm_by_chance;
  std::size_t compared_classes = 0;
  std::optional<HeardDifference> heard;  ///< from the target, of the same strikes
  std::optional<double> sample_s;        ///< what the build took for a sample of its dataset [s]
};

/// @return nothing where it was interrupted
/// @throws InputError, FileError  a split that leaks, conditions without common labels
/// @note Collective on world.
std::optional<std::vector<TransferRow>> run_transfer(const TransferSpec& spec,
                                                     const EvaluatedDatasets& datasets,
                                                     MPI_Comm world);

/// docs/learning.md names the fields.
nlohmann::ordered_json transfer_json(const TransferSpec& spec, const EvaluatedDatasets& datasets,
                                     const std::vector<TransferRow>& rows);
/// For people, in Markdown.
std::string transfer_text(const TransferSpec& spec, const EvaluatedDatasets& datasets,
                          const std::vector<TransferRow>& rows);

}  // namespace carillon::eval::studies
