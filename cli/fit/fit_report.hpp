#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "cli/fit/fit_inputs.hpp"
#include "eval/damping/fit_damping.hpp"

namespace carillon::cli {

/// All that `carillon fit` has to say.
struct FitReport {
  eval::DampingLaw law;
  std::vector<eval::DampingFit> fits;  ///< the first is the one asked for
  eval::DampingFit least_squares;      ///< for the comparison, whatever was asked for
  std::vector<FitSource> sources;
  double features_seconds = 0;
  double fit_seconds = 0;
};

/// Names as docs/damping-fits.md lists them; what is infinite is null.
nlohmann::json to_json(const FitReport& report);

/// The same for people.
void print_report(const FitReport& report);

/// Steps of the optimisers as comma-separated values.
std::string history_table(const std::vector<eval::DampingFit>& fits);

}  // namespace carillon::cli
