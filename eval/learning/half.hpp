#pragma once

#include <cstdint>
#include <span>

namespace carillon::eval::learning {

/// Numbers of 16 bits (binary16 of IEEE 754), rounded to the nearest, of two equally near ones to
/// the even. What is beyond 65504 becomes infinite; NaN stays NaN.
/// @param halves  as many as there are values
void to_half(std::span<const float> values, std::span<std::uint16_t> halves);
void from_half(std::span<const std::uint16_t> halves, std::span<float> values);

}  // namespace carillon::eval::learning
