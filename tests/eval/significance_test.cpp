// Statistics of evaluations against SciPy 1.10.1 and closed forms.
#include "eval/statistics/significance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/statistics/summary.hpp"

namespace carillon::eval {
namespace {

const std::vector<double> first = {0.4605, 0.0292, 0.1739, 0.0963, 0.1031, 0.1189,
                                   0.0403, 0.1178, 0.0805, 0.9938, 0.155,  0.1095};
const std::vector<double> second = {0.1543, 0.1224, 0.097,  0.1445, 0.2439, 0.1583,
                                    0.3245, 0.162,  0.1854, 0.4619, 0.2534, 0.1349};

TEST(SignedRankTest, OfFewPairsIsExact) {
  // scipy.stats.wilcoxon(first, second, mode='exact')
  const statistics::SignedRank test = statistics::signed_rank_test(first, second);
  EXPECT_EQ(test.pairs, 12u);
  EXPECT_EQ(test.positive, 28.0);
  EXPECT_EQ(test.positive + test.negative, 78.0);
  EXPECT_NEAR(test.p, 0.423828125, 1e-12);
  EXPECT_EQ(statistics::signed_rank_test(second, first).p, test.p);
}

TEST(SignedRankTest, WithTiesIsTheNormalApproximationWithTheirCorrection) {
  const std::vector<double> a = {0.5, 0.0, 0.2, 0.1, 0.1, 0.1, 0.0, 0.1, 0.1, 1.0, 0.2, 0.1};
  const std::vector<double> b = {0.2, 0.1, 0.1, 0.1, 0.2, 0.2, 0.3, 0.2, 0.2, 0.5, 0.3, 0.1};
  // scipy.stats.wilcoxon(a, b, mode='approx', zero_method='wilcox')
  const statistics::SignedRank test = statistics::signed_rank_test(a, b);
  EXPECT_EQ(test.pairs, 10u);
  EXPECT_EQ(std::min(test.positive, test.negative), 23.0);
  EXPECT_NEAR(test.p, 0.6385006468183431, 1e-12);
}

TEST(SignedRankTest, OfManyPairsIsTheNormalApproximation) {
  std::vector<double> a;
  for (int i = 1; i <= 70; ++i) a.push_back(i % 3 != 0 ? i + 0.5 : -(i + 0.5));
  // scipy.stats.wilcoxon(a, [0.0] * 70, mode='approx')
  const statistics::SignedRank test = statistics::signed_rank_test(a, std::vector<double>(70, 0.0));
  EXPECT_EQ(test.negative, 828.0);
  EXPECT_NEAR(test.p, 0.015277644425448848, 1e-12);
}

TEST(SignedRankTest, OfEqualValuesFindsNothing) {
  const statistics::SignedRank test = statistics::signed_rank_test(first, first);
  EXPECT_EQ(test.pairs, 0u);
  EXPECT_EQ(test.p, 1.0);
  EXPECT_THROW(statistics::signed_rank_test(first, std::vector{1.0}), core::InputError);
  EXPECT_THROW(statistics::signed_rank_test(std::vector{std::nan("")}, std::vector{1.0}),
               core::InputError);
}

TEST(SignedRankTest, OfAllPairsTheSameWayIsAsRareAsThatByChance) {
  // Every one of n signs alike: 2 of 2^n.
  for (int n = 1; n <= 50; ++n) {
    std::vector<double> a(static_cast<std::size_t>(n));
    std::iota(a.begin(), a.end(), 1);
    EXPECT_NEAR(statistics::signed_rank_test(a, std::vector<double>(a.size(), 0.0)).p,
                std::min(1.0, std::ldexp(2, -n)), 1e-18);
  }
}

TEST(WelchTest, IsSciPys) {
  std::vector<double> a, b;
  for (const double x : first) a.push_back(std::log(x));
  for (const double x : second) b.push_back(std::log(x));
  // scipy.stats.ttest_ind(numpy.log(first), numpy.log(second), equal_var=False)
  const statistics::WelchTest test = statistics::welch_test(a, b);
  EXPECT_NEAR(test.t, -1.237658056011499, 1e-10);
  EXPECT_NEAR(test.p, 0.23417288149366083, 1e-10);
  EXPECT_TRUE(std::isnan(statistics::welch_test(std::vector{1.0}, b).p));
  EXPECT_TRUE(std::isnan(statistics::welch_test(std::vector{1.0, 1.0}, std::vector{2.0, 2.0}).p));
}

TEST(Holm, IsTheKnownExample) {
  // R: p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")
  const std::vector<double> p = {0.01, 0.04, std::nan(""), 0.03, 0.005},
                            raised = statistics::holm(p);
  EXPECT_DOUBLE_EQ(raised[0], 0.03);
  EXPECT_DOUBLE_EQ(raised[1], 0.06);
  EXPECT_TRUE(std::isnan(raised[2]));
  EXPECT_DOUBLE_EQ(raised[3], 0.06);
  EXPECT_DOUBLE_EQ(raised[4], 0.02);
  EXPECT_EQ(statistics::holm(std::vector{0.6, 0.7})[0], 1.0);
}

TEST(Bootstrap, OfAMeanIsAsWideAsItsStandardError) {
  core::RandomStream normals(1, 2, "test"), draws(1, 3, "test");
  std::vector<double> values(400);
  for (double& value : values) value = 5 + 2 * normals.normal();
  const core::Range bounds = statistics::bootstrap(values, statistics::mean, draws);
  double variance = 0;
  for (const double value : values) variance += std::pow(value - statistics::mean(values), 2) / 399;
  const double half = 1.96 * std::sqrt(variance / 400);
  EXPECT_NEAR(bounds.low, statistics::mean(values) - half, 0.1 * half);
  EXPECT_NEAR(bounds.high, statistics::mean(values) + half, 0.1 * half);
  // The same stream, the same interval.
  core::RandomStream again(1, 3, "test");
  EXPECT_EQ(statistics::bootstrap(values, statistics::mean, again).low, bounds.low);
}

}  // namespace
}  // namespace carillon::eval
