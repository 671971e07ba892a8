#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/numbers.hpp"
#include "eval/damping/damping_data.hpp"
#include "synth/damping/damping.hpp"

namespace carillon::eval::damping {

/// What makes observed damping differ from the material's.
enum class Estimator {
  emg,           ///< maximum likelihood; exponential excess and Gaussian error (Sterling 2019, 4.2)
  emg_relative,  ///< the same with errors in proportion to the law's c, as those of features are
  least_squares,  ///< Gaussian error alone
  lower_bound     ///< no error, excess alone: the closest curve below all points
};

inline bool is_emg(Estimator estimator) {
  return estimator == Estimator::emg || estimator == Estimator::emg_relative;
}

/// A damping model whose numbers are sought.
struct DampingLaw {
  synth::damping::DampingKind kind = synth::damping::DampingKind::rayleigh;
  std::size_t parameters = 2;  ///< of a series (Caughey's); an expression's alphas are counted
  std::string expression;      ///< of DampingKind::expression, else empty
};

struct FitOptions {
  Estimator estimator = Estimator::emg;
  bool confidence = true;  ///< intervals by profile likelihood
  bool history = false;    ///< keep every step of the optimiser
};

/// One step of an optimiser.
struct FitStep {
  int start = 0;                   ///< which of the starts
  double log_likelihood = 0;       ///< of the data c; of another estimator: minus its cost
  double gradient = 0;             ///< norm in the optimiser's own scaled parameters
  std::vector<double> parameters;  ///< alphas, then sigma and eta where they are fitted
};

struct DampingFit {
  Estimator estimator = Estimator::emg;
  synth::damping::DampingModel model;  ///< with the numbers found
  double sigma = 0;  ///< of the Gaussian error of c [1/s], of emg_relative as a fraction of the
                     ///< law's c; 0 for the lower bound
  double eta = 0;    ///< rate of the exponential excess of c [s]; infinite where there is none
  double log_likelihood = 0;              ///< of the data under the estimator's own assumption
  std::vector<core::Range> confidence95;  ///< one for each alpha; infinite ends where the data
                                          ///< bound none; empty unless asked for
  std::size_t points = 0;
  int iterations = 0;  ///< of all starts
  bool converged = false;
  std::vector<FitStep> history;
  std::vector<std::string> remarks;  ///< what a user should know, e.g. that excess cannot be seen
};

/// Parameters of a damping model from observed (lambda, c).
/// @throws InputError  fewer points than can be fitted, values that are not finite or not positive,
///                     a law that cannot be fitted
DampingFit fit_damping(const DampingData& data, const DampingLaw& law,
                       const FitOptions& options = {});

}  // namespace carillon::eval::damping
