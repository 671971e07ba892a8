#pragma once

#include <string>

#include "eval/damping/detail/scaled_law.hpp"

namespace carillon::eval::damping {

/// How many alphas stand in a formula.
/// @throws InputError  none, one left out between others, or a formula that cannot be read
std::size_t count_alphas(const std::string& expression);

/// Any formula of lambda and its alphas. Which of them it is linear in is found by trying; a
/// formula linear in all is a linear_law(). Others have derivatives by differences, and candidates
/// drawn at random from all sizes, always the same.
/// @param near  alphas whose sizes are to be the units of the parameters, and the middle of the
///              candidates
ScaledLaw expression_law(const std::string& expression, const DampingData& data, double scale,
                         std::optional<std::size_t> along, const std::vector<double>& near);

}  // namespace carillon::eval::damping
