#include "eval/learning/half.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace carillon::eval {
namespace {

TEST(Halves, AreThoseOfTheStandard) {
  // IEEE 754-2019, section 3.6: sign, five bits of exponent, ten of fraction.
  const std::vector<std::pair<float, std::uint16_t>> known = {
      {0.0F, 0x0000},
      {-0.0F, 0x8000},
      {1.0F, 0x3c00},
      {-2.0F, 0xc000},
      {65504.0F, 0x7bff},
      {65520.0F, 0x7c00},
      {1.0F / 3, 0x3555},
      {0x1p-14F, 0x0400},
      {0x1p-24F, 0x0001},
      {0x1p-26F, 0x0000},
      {0x1.ff8p-15F, 0x03ff},
      {1 + 0x1p-11F, 0x3c00},  // between two: the even one
      {1 + 3 * 0x1p-11F, 0x3c02},
      {std::numeric_limits<float>::infinity(), 0x7c00}};
  for (const auto& [value, expected] : known) {
    std::uint16_t half = 0;
    learning::to_half(std::span(&value, 1), std::span(&half, 1));
    EXPECT_EQ(half, expected) << value;
  }
}

TEST(Halves, AllComeBack) {
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
    const auto half = static_cast<std::uint16_t>(bits);
    std::uint16_t again = 0;
    float value = 0;
    learning::from_half(std::span(&half, 1), std::span(&value, 1));
    learning::to_half(std::span(&value, 1), std::span(&again, 1));
    if (std::isnan(value)) {
      EXPECT_GT(half & 0x7fff, 0x7c00);
      EXPECT_GT(again & 0x7fff, 0x7c00);
    } else {
      EXPECT_EQ(again, half) << value;
    }
  }
}

TEST(Halves, AreOffByHalfAStepAtMost) {
  for (float value = 0x1p-14F; value < 1; value *= 1.001F) {
    std::uint16_t half = 0;
    float near = 0;
    learning::to_half(std::span(&value, 1), std::span(&half, 1));
    learning::from_half(std::span(&half, 1), std::span(&near, 1));
    EXPECT_LE(std::abs(near - value), 0x1p-11F * value);
  }
}

}  // namespace
}  // namespace carillon::eval
