#pragma once

#include <compare>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/studies/detail/damping_fits.hpp"
#include "eval/validation/estimator_errors.hpp"

namespace carillon::eval::studies {

/// Fits that are looked at together: of one parameter, in one dataset.
struct DampingPlace {
  std::string condition, features, from;
  std::string material;  ///< `all` for fits of every material
  std::size_t sounds = 0, parameter = 0;

  // NOLINTNEXTLINE(modernize-use-nullptr): the zero is the language's own
  auto operator<=>(const DampingPlace&) const = default;
};

struct DampingErrors {
  DampingPlace place;
  std::string estimator;
  validation::ErrorSummary summary;
};

/// Two estimators against each other.
struct DampingTest {
  DampingPlace place;
  std::string first, second;
  validation::EstimatorComparison found;
  /// Probabilities after Holm: over all pairs of estimators for one parameter, number of sounds,
  /// dataset and source of features, in all materials; all of them together are a family of their
  /// own.
  double signed_rank_holm = 0, welch_holm = 0;
  std::string ahead{};  ///< the one nearer to the truth where that is no chance, else ""
};

/// How many features the sounds of a condition have from one source.
struct FoundFeatures {
  std::string condition, features;
  std::size_t sounds = 0, without = 0;  ///< of these, without one to fit
  double median_per_sound = 0, reverberant_fraction = 0;
};

/// What `evaluate.damping` found.
struct DampingFindings {
  std::vector<DampingErrors> errors;
  std::vector<DampingTest> tests;
  std::vector<FoundFeatures> features{};
};

/// Errors of all fits and what tells estimators apart; no `features`. Ranks share the work; the
/// answer is the same on all of them.
/// @note Collective on world.
DampingFindings find_errors(const DampingValidation& validation, const EvaluatedDatasets& datasets,
                            const std::vector<FitBlock>& blocks, const FitResults& results,
                            MPI_Comm world);

std::vector<FoundFeatures> count_features(const DampingValidation& validation,
                                          const EvaluatedDatasets& datasets, FeatureStore& store);

/// docs/damping-validation.md names the fields.
/// @param failures  of tasks
nlohmann::ordered_json damping_json(const DampingValidation& validation,
                                    const EvaluatedDatasets& datasets,
                                    const DampingFindings& findings,
                                    const std::vector<nlohmann::json>& failures);

/// Rows of a list in the document as CSV; lists of two become two columns, `NAME_low` and
/// `NAME_high` or `first` and `second`.
std::string csv_of(const nlohmann::ordered_json& rows);
/// One row for each fit.
std::string fits_csv(const DampingValidation& validation, const EvaluatedDatasets& datasets,
                     const std::vector<FitBlock>& blocks, const FitResults& results);

/// For a person: errors over numbers of sounds, then material by material, and which estimator is
/// ahead.
std::string damping_text(const DampingValidation& validation, const EvaluatedDatasets& datasets,
                         const DampingFindings& findings);

}  // namespace carillon::eval::studies
