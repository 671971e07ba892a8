#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "eval/classification/confusion_chance.hpp"
#include "eval/classification/intervals.hpp"
#include "eval/scoring/answers.hpp"

namespace carillon::eval::scoring {

/// An accuracy, or a difference of two.
struct Estimate {
  double mean = 0;               ///< over seeds
  core::Range interval95;        ///< over groups; of several seeds over these, too
  double deviation = core::nan;  ///< of accuracies, between seeds; NaN for one
};

/// `mean` and `interval95`; null where there is none.
nlohmann::ordered_json to_json(const std::optional<Estimate>& estimate);
/// The same with `deviation`.
nlohmann::ordered_json accuracy_json(const std::optional<Estimate>& accuracy);

/// Rows of counts, one for each true class.
nlohmann::ordered_json counts_json(const classification::Confusion& confusion);

/// What classifiers that differ by their seed alone answered for the same samples.
class SeedAnswers {
 public:
  /// @param split  column that held the samples out: what their groups are
  explicit SeedAnswers(std::string split) : split_(std::move(split)) {}

  /// Of one seed.
  /// @throws InputError  for other samples than those of the seeds before
  void add(const PartAnswers& part, const std::vector<std::string>& classes);

  bool empty() const { return truth_.empty(); }
  std::size_t samples() const { return truth_.size(); }
  /// Different groups of samples whose answers stand and fall together.
  std::size_t groups() const;
  const std::vector<std::string>& classes() const { return classes_; }
  /// Of all seeds together.
  const classification::Confusion& confusion() const { return confusion_; }
  /// Nothing for no samples.
  /// @param inputs  hash of what decides the classifiers: seeds the bootstrap
  std::optional<Estimate> summary(classification::AccuracyKind kind,
                                  const std::string& inputs) const;
  /// How much more is right than of others' answers for the same samples, who may know other
  /// classes; nothing for no samples, or where they answered for others.
  /// @param kind         of accuracy
  /// @param probability  of its interval
  std::optional<Estimate> less(
      const SeedAnswers& others,
      classification::AccuracyKind kind = classification::AccuracyKind::plain,
      double probability = 0.95) const;
  /// Norms of the difference of confusions with others, for other samples of the same classes, that
  /// chance alone makes.
  classification::NormByChance norm_by_chance(const SeedAnswers& others) const;

 private:
  classification::TestedSamples tested() const { return {truth_, groups_, confusion_.classes}; }

  std::string split_;
  std::vector<std::string> keys_, classes_;
  std::vector<std::size_t> truth_, groups_;
  classification::Confusion confusion_;
  std::vector<std::vector<std::size_t>> predicted_;
};

}  // namespace carillon::eval::scoring
