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
  /// maximum likelihood; excess of two exponentials, errors of the features' own and in proportion
  /// to the law's c, outliers, and what a room hides
  mixture,
  emg,           ///< maximum likelihood; exponential excess and Gaussian error (Sterling 2019, 4.2)
  emg_relative,  ///< the same with errors in proportion to the law's c, as those of features are
  least_squares,  ///< Gaussian error alone
  lower_bound     ///< no error, excess alone: the closest curve below all points
};

/// Whether it has a model of the excess with a likelihood that least squares' can be compared with.
inline bool has_excess(Estimator estimator) {
  return estimator != Estimator::least_squares && estimator != Estimator::lower_bound;
}

/// Whether its sigma is a fraction of the law's c.
inline bool is_in_proportion(Estimator estimator) {
  return estimator == Estimator::emg_relative || estimator == Estimator::mixture;
}

/// A damping model whose numbers are sought.
struct DampingLaw {
  synth::damping::DampingKind kind = synth::damping::DampingKind::rayleigh;
  std::size_t parameters = 2;  ///< of a series (Caughey's); an expression's alphas are counted
  std::string expression;      ///< of DampingKind::expression, else empty
};

struct FitOptions {
  Estimator estimator = Estimator::mixture;
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

/// One of the exponentials that excess damping is drawn from.
struct ExcessPart {
  double share = 1;  ///< of all features
  double mean = 0;   ///< of c [1/s]
};

struct DampingFit {
  Estimator estimator = Estimator::mixture;
  synth::damping::DampingModel model;  ///< with the numbers found
  /// Of the Gaussian error of c [1/s], of emg_relative and mixture as a fraction of the law's c; 0
  /// for the lower bound.
  double sigma = 0;
  /// Rate of the exponential excess of c [s], of mixture one over its mean; infinite where there is
  /// none.
  double eta = 0;
  std::vector<ExcessPart> excess;         ///< of mixture
  std::size_t outliers = 0;               ///< of mixture: points more likely outliers than not
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
