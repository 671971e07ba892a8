#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/classification/intervals.hpp"

namespace carillon::cli {

/// `mean` over seeds, `interval95` (over groups; of several seeds over these, too) and the standard
/// `deviation` between seeds; null for no samples.
/// @param predicted  for each seed
/// @param inputs     hash of what decides the classifiers: seeds the bootstrap
nlohmann::ordered_json accuracy_summary(const eval::TestedSamples& tested,
                                        const std::vector<std::vector<std::size_t>>& predicted,
                                        eval::AccuracyKind kind, const std::string& inputs);

/// Null for what is no number.
nlohmann::ordered_json number_or_null(double value);

/// Share in percent with two digits, "-" for null.
std::string percent(const nlohmann::ordered_json& share);
/// "93.21 [90.10, 95.80]" of an accuracy_summary().
std::string with_interval(const nlohmann::ordered_json& summary);

/// A Markdown table, columns as wide as their widest cell; the first row is the header.
std::string markdown(const std::vector<std::vector<std::string>>& rows);

}  // namespace carillon::cli
