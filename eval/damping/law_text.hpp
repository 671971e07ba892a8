#pragma once

#include <string>
#include <vector>

#include "eval/damping/fit_damping.hpp"

namespace carillon::eval::damping {

/// "rayleigh", "caughey" (three terms), "caughey:5" (five), "power", "hybrid", or a formula whose
/// alphas are sought.
/// @throws InputError  neither a law's name nor a formula with alphas; a number of terms that is
///                     not one
DampingLaw damping_law(const std::string& word);

/// A law under the word that names it.
struct NamedLaw {
  std::string name;
  DampingLaw law;
};

/// The laws of a list with commas between them (those within a formula's parentheses aside); "all":
/// rayleigh, caughey, power and hybrid.
/// @throws InputError  as damping_law(); an empty word, the same law twice
std::vector<NamedLaw> damping_laws(const std::string& words);

/// "c = alpha1 + alpha2 lambda", with as many terms as the law has.
std::string formula_of(const DampingLaw& law);

inline constexpr Estimator all_estimators[] = {Estimator::mixture, Estimator::emg,
                                               Estimator::emg_relative, Estimator::least_squares,
                                               Estimator::lower_bound};

/// "mixture", "emg", "emg_relative", "least_squares", "lower_bound".
const char* name_of(Estimator estimator);

/// @throws InputError  no estimator has that name; says all
Estimator estimator_named(const std::string& name);

}  // namespace carillon::eval::damping
