#include "eval/learning/half.hpp"

#include <bit>

namespace carillon::eval::learning {

namespace {

constexpr std::uint32_t float_infinity = 0x7f800000U;
/// Exponents are off by 127 in floats and by 15 in halves, which have 13 digits less.
constexpr int digits_less = 13;
constexpr std::uint32_t bias_difference = (127U - 15U) << 23U;
/// The first float that rounds to infinity, and the least that is a normal half.
constexpr std::uint32_t first_infinite = 0x477ff000U, first_normal = 0x38800000U;

std::uint16_t half_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = (bits >> 16U) & 0x8000U, magnitude = bits & 0x7fffffffU;
  std::uint32_t half = 0;
  if (magnitude > float_infinity) {
    half = 0x7e00U;
  } else if (magnitude >= first_infinite) {
    half = 0x7c00U;
  } else if (magnitude >= first_normal) {
    const std::uint32_t odd = (magnitude >> digits_less) & 1U;
    half = (magnitude - bias_difference + 0xfffU + odd) >> digits_less;
  } else {
    // Adding 0.5 leaves multiples of 2^-24, the step of what is below, in the last digits.
    const float shifted = std::bit_cast<float>(magnitude) + 0.5F;
    half = std::bit_cast<std::uint32_t>(shifted) - std::bit_cast<std::uint32_t>(0.5F);
  }
  return static_cast<std::uint16_t>(sign | half);
}

float float_of(std::uint16_t half) {
  const std::uint32_t sign = (half & 0x8000U) << 16U, magnitude = half & 0x7fffU;
  std::uint32_t bits = 0;
  if (magnitude >= 0x7c00U) {
    bits = float_infinity | (magnitude << digits_less);
  } else if (magnitude >= 0x400U) {
    bits = (magnitude << digits_less) + bias_difference;
  } else {
    bits = std::bit_cast<std::uint32_t>(static_cast<float>(magnitude) * 0x1p-24F);
  }
  return std::bit_cast<float>(sign | bits);
}

}  // namespace

void to_half(std::span<const float> values, std::span<std::uint16_t> halves) {
  for (std::size_t i = 0; i < values.size(); ++i) halves[i] = half_of(values[i]);
}

void from_half(std::span<const std::uint16_t> halves, std::span<float> values) {
  for (std::size_t i = 0; i < halves.size(); ++i) values[i] = float_of(halves[i]);
}

}  // namespace carillon::eval::learning
