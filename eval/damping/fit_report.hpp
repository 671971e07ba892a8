#pragma once

#include <nlohmann/json.hpp>
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

/// Names as docs/damping-fits.md lists them; what is infinite is null.
nlohmann::json to_json(const FitReport& report);

/// The same for people.
void print_report(const FitReport& report);

/// Steps of the optimisers as comma-separated values.
std::string history_table(const std::vector<DampingFit>& fits);

}  // namespace carillon::eval::damping
