#include "core/numbers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace carillon::core {
namespace {

TEST(Median, IsTheMiddleOrTheMeanOfTheTwo) {
  EXPECT_TRUE(std::isnan(median({})));
  EXPECT_EQ(median({4.0}), 4.0);
  EXPECT_EQ(median({4.0, 1.0, 3.0}), 3.0);
  EXPECT_EQ(median({4.0, 1.0, 3.0, 0.0}), 2.0);
}

TEST(Quantile, IsNumPys) {
  const std::vector<double> values = {3, 1, 4, 1, 5, 9, 2, 6};
  // numpy.quantile(values, [0, 0.1, 0.25, 0.5, 0.9, 1])
  const double fractions[] = {0, 0.1, 0.25, 0.5, 0.9, 1};
  const double expected[] = {1, 1, 1.75, 3.5, 6.9, 9};
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(quantile(values, fractions[k]), expected[k], 1e-14);
  EXPECT_EQ(quantile(values, 0.5), median(values));
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(Peak, IsTheLargestMagnitude) {
  EXPECT_EQ(peak(std::vector<float>{0.25F, -0.5F, 0.125F}), 0.5);
  EXPECT_EQ(peak(std::vector<double>{1, -3, 2}), 3);
  EXPECT_EQ(peak(std::vector<float>{}), 0);
}

TEST(Levels, AreTheLogarithmsOfTheField) {
  EXPECT_DOUBLE_EQ(cents(2), 1200);
  EXPECT_DOUBLE_EQ(cents(std::exp2(-1.0 / 12)), -100);
  EXPECT_DOUBLE_EQ(decibels(1000), 30);
  EXPECT_DOUBLE_EQ(amplitude_decibels(0.1), -20);
}

}  // namespace
}  // namespace carillon::core
