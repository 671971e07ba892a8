#include "mpi/calibration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace carillon::mpi {
namespace {

TEST(Calibration, TakesTheMedianRatioOfAKind) {
  Calibration calibration;
  EXPECT_EQ(calibration.factor("modes"), 1);
  calibration.add("modes", 1, 3);
  calibration.add("modes", 2, 6);
  EXPECT_EQ(calibration.factor("modes"), 1);  // two tasks are no rule
  calibration.add("modes", 1, 500);           // one that hung
  EXPECT_NEAR(calibration.factor("modes"), 3, 1e-12);
  EXPECT_EQ(calibration.factor("samples"), 1);
}

TEST(Calibration, TheMedianOfManyIsThatOfTheSortedList) {
  std::mt19937 random(5);
  std::lognormal_distribution<double> draw(0.3, 1);
  Calibration calibration;
  std::vector<double> ratios;
  for (int i = 0; i < 501; ++i) {
    ratios.push_back(i % 7 == 0 ? 2.5 : draw(random));  // some alike
    calibration.add("samples", 4, 4 * ratios.back());
    if (ratios.size() < 3) continue;
    std::vector<double> sorted = ratios;
    std::sort(sorted.begin(), sorted.end());
    const std::size_t half = sorted.size() / 2;
    const double median =
        sorted.size() % 2 == 1 ? sorted[half] : std::sqrt(sorted[half - 1] * sorted[half]);
    ASSERT_NEAR(calibration.factor("samples"), median, 1e-12 * median);
  }
}

TEST(Calibration, ErrorsBeforeAndAfter) {
  // Estimates are three times too low, and off by a factor of 2 either way beside that.
  Calibration calibration;
  for (int i = 0; i < 300; ++i) calibration.add("modes", 10, 30 * std::pow(2, i % 3 - 1));
  const Calibration::Report report = calibration.report().at("modes");
  EXPECT_EQ(report.tasks, 300);
  EXPECT_NEAR(report.before.median, 3, 1e-9);
  EXPECT_NEAR(report.before.spread, 2, 1e-9);
  EXPECT_NEAR(report.after.median, 1, 1e-9);
  EXPECT_NEAR(report.after.spread, 2, 0.01);
}

TEST(Calibration, IgnoresWhatHasNoRatio) {
  Calibration calibration;
  calibration.add("modes", 0, 1);
  calibration.add("modes", 1, 0);
  EXPECT_TRUE(calibration.report().empty());
}

}  // namespace
}  // namespace carillon::mpi
