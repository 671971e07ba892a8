#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "eval/damping/fit_damping.hpp"
#include "eval/damping/fit_inputs.hpp"
#include "eval/damping/law_text.hpp"

namespace carillon::eval::damping {

/// One of several laws that were fitted to the same features by the same estimator.
struct ComparedLaw {
  NamedLaw named;
  DampingFit fit;
  double aic = 0;       ///< infinite where there are too few features for one
  std::string nothing;  ///< why there is no fit; "" where there is
};

/// All that `carillon fit` has to say.
struct FitReport {
  DampingLaw law;                     ///< the one asked for, or chosen
  std::vector<ComparedLaw> compared;  ///< where several were asked for
  std::vector<DampingFit> fits;       ///< the first is the one asked for
  DampingFit least_squares;           ///< for the comparison, whatever was asked for
  std::vector<FitSource> sources;
  double features_seconds = 0;
  double fit_seconds = 0;
};

/// Fits a law to the features of all sources. Of several laws the one of the lowest AIC by the
/// first estimator is chosen (corrected for small samples; Hurvich and Tsai 1989), of those that
/// stay positive in the features' band.
/// @param estimators   the first is the one asked for
/// @param with_history  whether every step of the optimisers is kept
/// @throws InputError  no sources, no feature that can be used (says of each source why), no law
///                     that can be fitted
FitReport fit_sources(std::vector<FitSource> sources, std::span<const NamedLaw> laws,
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
