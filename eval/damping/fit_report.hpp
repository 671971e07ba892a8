#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "eval/damping/fit_damping.hpp"
#include "eval/damping/fit_inputs.hpp"

namespace carillon::eval::damping {

/// All that `carillon fit` has to say.
struct FitReport {
  DampingLaw law;
  std::vector<DampingFit> fits;  ///< the first is the one asked for
  DampingFit least_squares;      ///< for the comparison, whatever was asked for
  std::vector<FitSource> sources;
  double features_seconds = 0;
  double fit_seconds = 0;
};

/// Fits a law to the features of all sources.
/// @param estimators   the first is the one asked for
/// @param with_history  whether every step of the optimisers is kept
/// @throws InputError  no sources, no feature that can be used (says of each source why)
FitReport fit_sources(std::vector<FitSource> sources, const DampingLaw& law,
                      std::span<const Estimator> estimators, bool with_history);

/// What gave no feature that can be used, a line for each source; "" where all did.
std::string useless_sources(const std::vector<FitSource>& sources);

/// Names as docs/damping-fits.md lists them; what is infinite is null.
nlohmann::json to_json(const FitReport& report);

/// The same for people.
void print_report(const FitReport& report);

/// Steps of the optimisers as comma-separated values.
std::string history_table(const std::vector<DampingFit>& fits);

}  // namespace carillon::eval::damping
