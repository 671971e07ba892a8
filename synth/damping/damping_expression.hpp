#pragma once

#include <functional>
#include <span>
#include <string>

namespace carillon::synth::damping {

/// Reads a formula of lambda [rad^2/s^2], omega [rad/s], f [Hz], pi and alpha1, alpha2, ... once,
/// as muParser does: + - * / ^, comparisons, `condition ? a : b`, sqrt, exp, ln, log10, min, max,
/// abs and others.
/// @param parameters  alpha1, alpha2, ...: each must stand in the formula
/// @return c(lambda) [1/s]; not to be shared between threads
/// @throws InputError  what cannot be read, with its position and the nearest name; an assignment,
///                     several results, a parameter that is missing or idle
std::function<double(double)> compile_expression(const std::string& expression,
                                                 std::span<const double> parameters);

}  // namespace carillon::synth::damping
