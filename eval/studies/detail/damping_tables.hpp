#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/studies/detail/damping_fits.hpp"

namespace carillon::eval::studies {

/// What compute_fits() returned for every block, in the order of the blocks; null where it failed.
using FitResults = std::vector<nlohmann::json>;

/// Errors of all fits and what tells estimators apart; docs/damping-validation.md names the fields.
/// Ranks share the work; the answer is the same on all of them.
/// @note Collective on world.
nlohmann::ordered_json damping_document(const DampingValidation& validation,
                                        const EvaluatedDatasets& datasets,
                                        const std::vector<FitBlock>& blocks,
                                        const FitResults& results, MPI_Comm world);

/// How many features the sounds of each condition have from each source.
nlohmann::ordered_json found_features(const DampingValidation& validation,
                                      const EvaluatedDatasets& datasets, FeatureStore& store);

/// Rows of a list in the document as CSV; lists of two become two columns, `NAME_low` and
/// `NAME_high` or `first` and `second`.
std::string csv_of(const nlohmann::ordered_json& rows);
/// One row for each fit.
std::string fits_csv(const DampingValidation& validation, const EvaluatedDatasets& datasets,
                     const std::vector<FitBlock>& blocks, const FitResults& results);

/// For a person: errors over numbers of sounds, then material by material, and which estimator is
/// ahead.
std::string damping_text(const DampingValidation& validation,
                         const nlohmann::ordered_json& document);

}  // namespace carillon::eval::studies
