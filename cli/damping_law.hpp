#pragma once

#include <cstddef>
#include <string>

#include "eval/damping/fit_damping.hpp"

namespace carillon::cli {

/// The damping model that is sought, from `--model`: a kind's name, or a formula with alphas.
/// @param parameters  of a Caughey series
/// @throws InputError  a word that is neither (names the nearest), a formula without alphas or that
///                     cannot be read
eval::DampingLaw damping_law(const std::string& model, std::size_t parameters);

}  // namespace carillon::cli
