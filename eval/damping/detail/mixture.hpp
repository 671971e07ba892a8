#pragma once

#include <limits>

#include "eval/damping/detail/jet.hpp"

namespace carillon::eval::damping {

/// What a mixture's density is differentiated by, in this order.
namespace mixture_place {
enum { law, sigma, touched, spared, share, count };
}
using MixtureJet = Jet<mixture_place::count>;

/// One observed damping coefficient, in any unit.
struct Observed {
  double c = 0;
  double error = 0;  ///< standard error; 0: not known
  double ceiling =
      std::numeric_limits<double>::infinity();  ///< c above it would not have been seen
  double proportion = 0;  ///< standard error as a fraction of the law's value, besides error
};

/// How often an observation is something that is no mode of the material, or not one alone.
inline constexpr double outlier_share = 0.05;

/// ln of the density of what is observed where the law's value is m:
///
///   c = m + N(0, (s^2 + proportion^2) m^2 + error^2) + excess
///   excess ~ Exp(mean t1) with probability w, else Exp(mean t2): a support touches some modes and
///   spares others, whose excess is small; the square of a mode shape at a random place (Sterling
///   2019, eq. 4.16) is such a mixture to a few percent
///
/// and with probability `outlier_share` an outlier, log-logistic about the law: m / (c + m)^2.
/// Where there is a ceiling the density is that of what lies below it (truncated likelihood).
///
/// @param m  the law's value > 0; numbers are ln s, ln t1, ln t2 and the logit of w
/// @return with derivatives by m, ln s, ln t1, ln t2 and the logit of w
MixtureJet mixture_log_density(const Observed& observed, double m, const Eigen::Vector4d& numbers);

/// Probability that an observation is an outlier under the same numbers.
double outlier_probability(const Observed& observed, double m, const Eigen::Vector4d& numbers);

}  // namespace carillon::eval::damping
