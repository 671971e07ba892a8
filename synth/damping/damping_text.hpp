#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/units.hpp"
#include "synth/damping/damping.hpp"

namespace carillon::synth::damping {

/// Number of an alpha from its name, counted from 1: 3 for "alpha3"; none for other words.
std::optional<int> alpha_number(const std::string& key);

/// Dimension of an alpha under the word that stands for `damping` ("" where nothing does): alpha2
/// of Rayleigh's and Caughey's may carry a unit of time, all others are plain numbers in SI units.
core::Dimension alpha_dimension(const std::string& word, int number);

/// A damping model as a configuration states it.
/// @param word    a model's name, a formula (see damping_expression.hpp), or "" for Rayleigh's
/// @param alphas  alpha1, alpha2, ... by number; those of Rayleigh's that are left out are zero
/// @throws InputError  a model that does not exist, alphas that are missing or too many, or a
///                     formula that cannot be read
DampingModel make_damping(const std::string& word, const std::map<int, double>& alphas);

}  // namespace carillon::synth::damping
